use super::*;
use crate::brep::Model;
use crate::shapes::{circle, extrude, rectangle};
use glam::DVec2;

fn plate() -> Model {
    extrude(&[rectangle(4.1, 2.9), vec![circle(DVec2::new(2.0, 1.5), 0.5).reversed()]], 1.3)
}

fn totals(model: &Model, plan: &Plan) -> Vec<usize> {
    let count = |f: &crate::brep::Face| {
        f.loops.iter().flat_map(|l| &l.uses).map(|u| plan.edges[u.edge].count()).sum()
    };
    model.faces.iter().map(count).collect()
}

#[test]
fn every_face_is_even_for_any_size() {
    let m = plate();
    for k in 1..60 {
        let size = 0.05 * f64::from(k);
        let p = plan(&m, &SizeRules::of(size), &Limits::default());
        assert!(totals(&m, &p).iter().all(|n| n % 2 == 0 && *n >= 4), "{size}: {:?}", totals(&m, &p));
        assert!(p.infeasible.is_empty());
    }
}

#[test]
fn ends_are_the_vertices_and_shares_ascend() {
    let m = plate();
    let p = plan(&m, &SizeRules::of(0.3), &Limits::default());
    for (e, n) in m.edges.iter().zip(&p.edges) {
        assert_eq!([n.points[0], n.points[n.count()]], e.ends.map(|v| m.vertices[v].point));
        assert!(n.shares.windows(2).all(|w| w[0] < w[1]));
    }
}

#[test]
fn frozen_edges_keep_their_counts_and_odd_faces_are_told() {
    let m = plate();
    let bottom: Vec<usize> =
        m.faces[m.faces.len() - 2].loops.iter().flat_map(|l| &l.uses).map(|u| u.edge).collect();
    let mut limits = Limits { frozen: vec![None; m.edges.len()], ..Limits::default() };
    limits.frozen[bottom[0]] = Some(7);
    let p = plan(&m, &SizeRules::of(0.3), &limits);
    assert_eq!(p.edges[bottom[0]].count(), 7);
    assert!(p.infeasible.is_empty() && totals(&m, &p).iter().all(|n| n % 2 == 0));
    // All edges of the bottom frozen to an odd total.
    for (k, &e) in bottom.iter().enumerate() {
        limits.frozen[e] = Some(if k == 0 { 7 } else { 8 });
    }
    let p = plan(&m, &SizeRules::of(0.3), &limits);
    // The bottom, and the rest of the closed surface, which its edges cut off from it.
    assert_eq!(p.infeasible.len(), 2);
    assert!(p.infeasible.iter().any(|i| i.faces == [m.faces.len() - 2]));
    assert!(p.infeasible.iter().all(|i| i.frozen == {
        let mut b = bottom.clone();
        b.sort_unstable();
        b
    }));
    assert!(p.edges[bottom[0]].count() == 7);
}

#[test]
fn curvature_and_gradation_make_small_edges() {
    let m = plate();
    let p = plan(&m, &SizeRules::of(1.0), &Limits::default());
    let circles: Vec<usize> =
        m.edges.iter().zip(&p.edges).filter(|(e, _)| e.is_closed()).map(|(_, n)| n.count()).collect();
    assert!(circles.iter().all(|n| (11..=13).contains(n)), "{circles:?}");
}
