//! Outlines of SVG pictures. Closed subpaths (and filled ones, which SVG closes itself) are loops, open stroked ones
//! scars. Text, images and hidden shapes are left out; y is turned upward. usvg resolves transforms and shapes, in
//! 32-bit numbers: coordinates are good to about 1e-7 of the picture's size.

use crate::{
    IoError, JobInput, Place,
    curves::{Piece, chain, outlines},
};
use csalf_geom::curve::Curve;
use csalf_geom::{Geometry, Point2};
use usvg::tiny_skia_path::{PathSegment, Point};

const FORMAT: &str = "SVG";

/// Reads the outlines of a picture.
///
/// # Errors
/// [`IoError::Syntax`] if it is no SVG; [`IoError::Empty`] if it has no closed path.
pub fn read(bytes: &[u8]) -> Result<JobInput, IoError> {
    let options = usvg::Options {
        // Nothing is loaded from elsewhere.
        image_href_resolver: usvg::ImageHrefResolver {
            resolve_data: Box::new(|_, _, _| None),
            resolve_string: Box::new(|_, _| None),
        },
        ..usvg::Options::default()
    };
    let tree = usvg::Tree::from_data(bytes, &options)
        .map_err(|e| IoError::syntax(FORMAT, Place::Whole, e.to_string()))?;
    let mut out = Found::default();
    walk(tree.root(), &mut out);
    let size = Geometry::new(out.open.iter().map(|p| p.ahead.clone()).collect()).diagonal();
    let (joined, open) = chain(out.open, Geometry::MAX_GAP * size);
    out.loops.extend(joined.into_iter().map(|c| (String::new(), c)));
    let scars = open.into_iter().map(|c| (String::new(), c)).collect();
    outlines(FORMAT, out.loops, scars, Vec::new())
}

#[derive(Default)]
struct Found {
    loops: Vec<(String, Vec<Curve>)>,
    /// Curves of open, stroked subpaths.
    open: Vec<Piece>,
}

fn walk(group: &usvg::Group, out: &mut Found) {
    for node in group.children() {
        match node {
            usvg::Node::Group(g) => walk(g, out),
            usvg::Node::Path(p) if p.is_visible() => {
                if let Some(data) = p.data().clone().transform(p.abs_transform()) {
                    add_path(p.id(), &data, p.fill().is_some(), out);
                }
            }
            _ => {}
        }
    }
}

fn add_path(id: &str, data: &usvg::tiny_skia_path::Path, filled: bool, out: &mut Found) {
    let xy = |p: Point| Point2::new(f64::from(p.x), -f64::from(p.y));
    let mut curves: Vec<Curve> = Vec::new();
    let (mut start, mut at) = (Point2::ZERO, Point2::ZERO);
    let mut finish = |curves: &mut Vec<Curve>, start: Point2, at: Point2, closed: bool| {
        let mut done = std::mem::take(curves);
        if done.is_empty() {
            return;
        }
        if (closed || filled) && at != start {
            done.push(Curve::line(at, start));
        }
        if closed || filled || at == start {
            out.loops.push((id.to_owned(), done));
        } else {
            out.open.extend(done.into_iter().filter_map(Piece::new));
        }
    };
    for segment in data.segments() {
        let curve = match segment {
            PathSegment::MoveTo(p) => {
                finish(&mut curves, start, at, false);
                (start, at) = (xy(p), xy(p));
                continue;
            }
            PathSegment::Close => {
                finish(&mut curves, start, at, true);
                at = start;
                continue;
            }
            PathSegment::LineTo(p) => Curve::line(at, xy(p)),
            PathSegment::QuadTo(b, p) => Curve::Quadratic([at, xy(b), xy(p)]),
            PathSegment::CubicTo(b, c, p) => Curve::Cubic([at, xy(b), xy(c), xy(p)]),
        };
        let to = curve.end();
        // A line of no length is nothing; a curve may come back to where it began.
        if curve.is_finite() && !(to == at && matches!(curve, Curve::Polyline(_))) {
            curves.push(curve);
            at = to;
        }
    }
    finish(&mut curves, start, at, false);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Input;

    #[test]
    fn shapes_paths_and_transforms() {
        let text = r#"<svg xmlns="http://www.w3.org/2000/svg" width="100" height="100">
            <path id="a" transform="translate(10 0) scale(2)" d="M0 0H20V20H0Z M5 5V10H10V5Z"/>
            <circle cx="80" cy="80" r="10"/>
            <path fill="none" stroke="black" d="M75 80 L85 80"/></svg>"#;
        let Input::Curves(c) = read(text.as_bytes()).unwrap().input else { panic!("curves expected") };
        assert_eq!(c.len(), 2);
        assert_eq!((c[0].name.as_str(), c[0].geometry.loops.len()), ("a", 2));
        assert_eq!(c[0].geometry.loops[0].edges[0].curve.end(), Point2::new(50.0, 0.0));
        assert_eq!(c[0].geometry.loops[0].edges[1].curve.end(), Point2::new(50.0, -40.0));
        assert_eq!(c[1].geometry.scars.len(), 1);
        assert!(c.iter().all(|c| c.geometry.check().is_empty()));
        assert!(read(b"<svg xmlns='http://www.w3.org/2000/svg' width='1' height='1'/>").is_err());
        assert!(read(b"<html/>").is_err());
    }
}
