use super::*;

const FULL: &str = r#"{"name":"n","about":"a",
 "loops":[{"kind":"outer","nodes":[[0,0],[4,0],[4,4],[0,4]]},
          {"kind":"hole","nodes":[[1,1],[1,2],[2,2],[2,1]]},
          {"kind":"hole","name":"bolt","nodes":[[3,3],[3,3.5],[3.5,3.5],[3.5,3]]}],
 "scars":[{"nodes":[[0.5,0.5],[0.5,0.7]]}],
 "points":[{"xy":[0.1,0.3]},{"xy":[0.2,3.3],"size":0.25,"name":"spot"}],
 "size":{"kind":"sources","far":1,"sources":[{"xy":[1,1],"h":0.1,"radius":0,"falloff":2}]},
 "local_region":{"circle":[1,2,3]},
 "layers":{"hole*":{"count":5,"law":"ramp"},"bolt":{"thicknesses":[0.1,0.3]},"outer":{"count":2,"ratio":1.5,"first":0.01}},
 "options":{"method":"tqm","threads":2}}"#;

fn full() -> JobDocument {
    read(FULL.as_bytes()).unwrap()
}

fn error(text: &str) -> String {
    read(text.as_bytes()).unwrap_err().to_string()
}

#[test]
fn everything_that_the_format_has_is_read() {
    let JobDocument { job, options, notes } = full();
    assert_eq!(notes, Vec::<String>::new());
    let names: Vec<&str> = job.domain.loops.iter().map(|l| l.name.as_str()).collect();
    assert_eq!(names, ["outer", "hole0", "bolt"]);
    assert_eq!(job.domain.loops[1].kind, LoopKind::Hole);
    assert_eq!(job.domain.loops[1].nodes[1], Point2::new(1.0, 2.0));
    assert_eq!(job.domain.scars[0].name, "scar0");
    assert_eq!(job.domain.points[1], HardPoint { name: "spot".into(), xy: xy([0.2, 3.3]), size: Some(0.25) });
    assert!(matches!(&job.size, SizeSpec::Sources { far: 1.0, sources } if sources[0].falloff == 2.0));
    assert_eq!(job.local_region, Some([1.0, 2.0, 3.0]));
    assert_eq!(job.layers[0], ("hole*".into(), LayerSpec { count: 5, law: LayerLaw::Ramp, first: None }));
    assert_eq!(job.layers[1].1.law, LayerLaw::Explicit(vec![0.1, 0.3]));
    assert_eq!(job.layers[1].1.count, 2);
    assert_eq!(job.layers[2].1, LayerSpec { count: 2, law: LayerLaw::Geometric(1.5), first: Some(0.01) });
    assert_eq!((options.method, options.threads), (Some(Method::Tqm), Some(2)));
    let mut o = Options::default();
    options.apply(&mut o);
    assert_eq!((o.method, o.threads, o.preset), (Method::Tqm, 2, Preset::Quality));
}

#[test]
fn writing_and_reading_keep_everything() {
    let mut doc = full();
    doc.job.domain.loops[0].nodes[0] = Point2::new(0.1 + 0.2, -1.0 / 3.0 * 1e-300);
    let mut text = Vec::new();
    write(&doc.job, &doc.options, &mut text).unwrap();
    assert_eq!(read(&text).unwrap(), doc);
    doc.job.size = SizeSpec::Background {
        points: vec![xy([0.0, 0.0]), xy([1.0, 0.0]), xy([0.0, 1.0])],
        triangles: vec![[0, 1, 2]],
        values: vec![0.1, 0.2, 0.3],
    };
    let mut text = Vec::new();
    write(&doc.job, &doc.options, &mut text).unwrap();
    assert_eq!(read(&text).unwrap(), doc);
}

#[test]
fn unknown_keys_and_repeated_names_are_notes() {
    let text = r#"{"name":"x","colour":1,"loops":[{"kind":"outer","name":"a","nodes":[],"id":3},
        {"kind":"hole","name":"a","nodes":[]}],"size":{"kind":"boundary","hh":1}}"#;
    let notes = read(text.as_bytes()).unwrap().notes;
    assert_eq!(
        notes,
        [
            "unknown key `colour` ignored",
            "unknown key `loops.0.id` ignored",
            "unknown key `size.hh` ignored",
            "the name `a` is used 2 times"
        ]
    );
}

#[test]
fn errors_say_where() {
    let e = error(r#"{"name":"x","loops":[{"kind":"outer","nodes":[[0,0],[1,0],[1]]}]}"#);
    assert!(e.contains("at loops[0].nodes[2]"), "{e}");
    let e = error(r#"{"name":"x","loops":[{"kind":"inner","nodes":[]}]}"#);
    assert!(e.contains("loops[0].kind") && e.contains("inner"), "{e}");
    let e = error("{\"name\":\"x\",\n\"loops\":[}");
    assert!(e.contains("line 2"), "{e}");
    let e = error(r#"{"loops":[],"size":{"kind":"uniform"}}"#);
    assert!(e.contains("at size") && e.contains("`h`"), "{e}");
    let e = error(r#"{"loops":[],"size":{"kind":"uniform","h":-1}}"#);
    assert!(e.contains("size.h") && e.contains("-1"), "{e}");
    let e = error(r#"{"loops":[],"layers":{"outer":{"law":"ramp"}}}"#);
    assert!(e.contains("layers.outer") && e.contains("count"), "{e}");
    let e = error(
        r#"{"loops":[],"size":{"kind":"background","points":[[0,0]],"triangles":[[0,0,1]],"values":[1]}}"#,
    );
    assert!(e.contains("size.triangles[0]"), "{e}");
    assert!(error("").contains("line 1"));
    assert!(error("{\"loops\":[]} x").contains("trailing"));
}

#[test]
fn numbers_that_json_has_not_are_not_written() {
    let mut doc = full();
    doc.job.domain.loops[0].nodes[0].x = f64::NAN;
    assert!(matches!(write(&doc.job, &doc.options, &mut Vec::new()), Err(IoError::Unsupported { .. })));
}

#[test]
fn the_schema_knows_the_keys() {
    let s = schema();
    for key in ["loops", "scars", "points", "size", "layers", "local_region", "options"] {
        assert!(s["properties"].get(key).is_some(), "{key}");
    }
    assert_eq!(s["required"], serde_json::json!(["loops"]));
    assert!(
        s["$defs"]["SizeSchema"].to_string().contains("falloff") || s["$defs"].get("SourceFile").is_some()
    );
}
