use super::*;
use crate::MeshView;
use csalf_geom::{Point2, QuadId, VertexId};
use csalf_mesh::{NamedSets, QuadMesh};

fn two_quads() -> (QuadMesh, NamedSets) {
    let p = |x: f64, y: f64| Point2::new(x, y);
    let points = vec![p(0., 0.), p(1., 0.), p(2., 0.), p(0., 1.), p(1., 1.), p(1.2, 0.3)];
    let quads = vec![[0, 1, 4, 3].map(VertexId), [1, 2, 4, 5].map(VertexId)];
    let sets = NamedSets { quads: vec![("layer0".into(), vec![QuadId(0)])], ..NamedSets::default() };
    (QuadMesh { points, quads, triangles: vec![] }, sets)
}

#[test]
fn good_quads_are_green_or_blue_and_bad_ones_red() {
    let (mesh, sets) = two_quads();
    let draw = |sets: &NamedSets| {
        let mut text = Vec::new();
        write_svg(&MeshView { mesh: &mesh, heights: &[], sets, cell_data: &[], title: "a <b>" }, &mut text)
            .unwrap();
        String::from_utf8(text).unwrap()
    };
    let (plain, layered) = (draw(&NamedSets::default()), draw(&sets));
    assert!(plain.contains("<title>a &lt;b></title>"));
    // The second quad is concave.
    assert_eq!(plain.matches("<path fill=\"#dc1414\"").count(), 1);
    assert_ne!(plain, layered);
    assert_eq!(plain.lines().filter(|l| l.starts_with("<path fill=\"#")).count(), 2);
}

#[test]
fn a_png_has_its_signature_and_size() {
    let (mesh, sets) = two_quads();
    let mut bytes = Vec::new();
    write_png(&MeshView { mesh: &mesh, heights: &[], sets: &sets, cell_data: &[], title: "" }, &mut bytes)
        .unwrap();
    assert_eq!(&bytes[..8], b"\x89PNG\r\n\x1a\n");
    let width = u32::from_be_bytes([bytes[16], bytes[17], bytes[18], bytes[19]]);
    assert_eq!(width, 1104);
}

#[test]
fn broken_meshes_are_refused() {
    let (mut mesh, sets) = two_quads();
    mesh.points[0].x = f64::NAN;
    let view = MeshView { mesh: &mesh, heights: &[], sets: &sets, cell_data: &[], title: "" };
    assert!(write_svg(&view, &mut Vec::new()).is_err());
    mesh.points.truncate(2);
    let view = MeshView { mesh: &mesh, heights: &[], sets: &sets, cell_data: &[], title: "" };
    assert!(write_png(&view, &mut Vec::new()).is_err());
    let empty = MeshView { mesh: &QuadMesh::default(), heights: &[], sets: &sets, cell_data: &[], title: "" };
    assert!(write_png(&empty, &mut Vec::new()).is_ok());
}

#[test]
fn colours_follow_other_values() {
    let (mesh, sets) = two_quads();
    let view = MeshView { mesh: &mesh, heights: &[], sets: &sets, cell_data: &[], title: "" };
    let draw = |values: &[f64], limits: [f64; 2]| {
        let mut text = Vec::new();
        write_svg_by(&view, &Shade { values, limits }, &mut text).map(|()| String::from_utf8(text).unwrap())
    };
    // Smaller is better here: the limits are turned round.
    let text = draw(&[2.0, 6.0], [6.0, 2.0]).unwrap();
    let fills: Vec<&str> =
        text.lines().filter(|l| l.starts_with("<path fill=\"#")).map(|l| &l[12..19]).collect();
    let swapped = draw(&[6.0, 2.0], [2.0, 6.0]).unwrap();
    assert_eq!(fills.len(), 2);
    assert!(fills.iter().all(|f| swapped.contains(f)));
    for label in [">6<", ">5<", ">4<", ">3<", ">2<"] {
        assert!(text.contains(label), "{label}");
    }
    assert!(draw(&[f64::NAN, 2.0], [6.0, 2.0]).unwrap().contains("#bebec8"));
    assert!(draw(&[1.0, 1.0], [1.0, 1.0]).is_ok());
    assert!(draw(&[1.0], [0.0, 1.0]).is_err());
    let mut bytes = Vec::new();
    write_png_by(&view, &Shade { values: &[0.5, 1.5], limits: [0.0, 2.0] }, &mut bytes).unwrap();
    assert!(bytes.starts_with(b"\x89PNG"));
}

/// A cube, its quads turned outwards: three are seen, the other three are left out. Open, all are drawn, far ones first.
#[test]
fn a_closed_mesh_in_space_shows_its_near_side() {
    let points = [(0., 0.), (1., 0.), (1., 1.), (0., 1.), (0., 0.), (1., 0.), (1., 1.), (0., 1.)];
    let heights = [0., 0., 0., 0., 1., 1., 1., 1.];
    let quads = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]];
    let mut mesh = QuadMesh {
        points: points.map(Point2::from).to_vec(),
        quads: quads.map(|q| q.map(VertexId)).to_vec(),
        triangles: vec![],
    };
    let sets = NamedSets::default();
    let draw = |mesh: &QuadMesh| {
        let view = MeshView { mesh, heights: &heights, sets: &sets, cell_data: &[], title: "cube" };
        let mut text = Vec::new();
        write_svg(&view, &mut text).unwrap();
        String::from_utf8(text).unwrap()
    };
    let colours = |text: &str| -> Vec<String> {
        let fills = text.lines().filter(|l| l.starts_with("<path fill=\"#"));
        fills.flat_map(|l| vec![l[12..19].to_owned(); l.matches('M').count()]).collect()
    };
    let seen = colours(&draw(&mesh));
    assert_eq!(seen.len(), 3);
    // In a perfect cube all are of one colour, but for the light.
    assert!(seen[0] != seen[1] && seen[1] != seen[2] && seen[2] != seen[0], "{seen:?}");
    // Turned inwards as a whole it looks the same.
    let mut inside_out = mesh.clone();
    inside_out.quads.iter_mut().for_each(|q| q.reverse());
    assert_eq!(colours(&draw(&inside_out)), seen);
    // Without its lid the bottom is seen, too, and is drawn first.
    mesh.quads.remove(1);
    let open = colours(&draw(&mesh));
    assert_eq!(open.len(), 5);
    let mut png = Vec::new();
    let view = MeshView { mesh: &mesh, heights: &heights, sets: &sets, cell_data: &[], title: "" };
    write_png(&view, &mut png).unwrap();
    assert_eq!(&png[..8], b"\x89PNG\r\n\x1a\n");
}
