//! Draws the scene as PNG. No fonts: the labels of the bar are drawn with strokes.

use super::scene::{Rgb, Scene};
use super::{FORMAT, Shade};
use crate::{IoError, MeshView, Place};
use std::io::Write;
use tiny_skia::{Color, FillRule, LineCap, Paint, Path, PathBuilder, Pixmap, Rect, Stroke, Transform};

fn paint(colour: Rgb, anti_alias: bool) -> Paint<'static> {
    let mut p = Paint { anti_alias, ..Paint::default() };
    p.set_color_rgba8(colour[0], colour[1], colour[2], 255);
    p
}

fn xy([x, y]: [f64; 2]) -> (f32, f32) {
    (x as f32, y as f32)
}

/// Strokes of a digit or point in a box of 4 wide and 6 high, y downward.
const fn strokes(c: char) -> &'static [&'static [(u8, u8)]] {
    match c {
        '0' => &[&[(0, 0), (4, 0), (4, 6), (0, 6), (0, 0)]],
        '1' => &[&[(1, 1), (2, 0), (2, 6)]],
        '3' => &[&[(0, 0), (4, 0), (4, 6), (0, 6)], &[(0, 3), (4, 3)]],
        '4' => &[&[(0, 0), (0, 3), (4, 3)], &[(4, 0), (4, 6)]],
        '6' => &[&[(4, 0), (0, 0), (0, 6), (4, 6), (4, 3), (0, 3)]],
        '8' => &[&[(0, 0), (4, 0), (4, 6), (0, 6), (0, 0)], &[(0, 3), (4, 3)]],
        '9' => &[&[(4, 3), (0, 3), (0, 0), (4, 0), (4, 6), (0, 6)]],
        '-' => &[&[(1, 3), (3, 3)]],
        '2' => &[&[(0, 0), (4, 0), (4, 3), (0, 3), (0, 6), (4, 6)]],
        '5' => &[&[(4, 0), (0, 0), (0, 3), (4, 3), (4, 6), (0, 6)]],
        '7' => &[&[(0, 0), (4, 0), (2, 6)]],
        '.' => &[&[(1, 6), (2, 6)]],
        _ => &[],
    }
}

/// A label as a path; `at` is its left end and the middle of its height.
fn label(text: &str, at: [f64; 2]) -> Option<Path> {
    let mut b = PathBuilder::new();
    let (mut x, y) = xy([at[0], at[1] - 4.0]);
    let size = 8.0 / 6.0;
    for c in text.chars() {
        for line in strokes(c) {
            for (k, &(u, v)) in line.iter().enumerate() {
                let (px, py) = (x + f32::from(u) * size, y + f32::from(v) * size);
                if k == 0 { b.move_to(px, py) } else { b.line_to(px, py) }
            }
        }
        x += if c == '.' { 4.0 } else { 7.5 };
    }
    b.finish()
}

/// Writes a picture of a mesh.
///
/// # Errors
/// [`IoError::Write`]; [`IoError::Unsupported`] if the mesh is broken.
pub fn write_png(out: &MeshView<'_>, w: &mut dyn Write) -> Result<(), IoError> {
    draw(&Scene::new(out, None)?, w)
}

/// Writes a picture of a mesh, coloured by `shade`.
///
/// # Errors
/// As [`write_png`]; [`IoError::Unsupported`] also if there is not one value per element.
pub fn write_png_by(out: &MeshView<'_>, shade: &Shade<'_>, w: &mut dyn Write) -> Result<(), IoError> {
    draw(&Scene::new(out, Some(shade))?, w)
}

fn draw(s: &Scene, w: &mut dyn Write) -> Result<(), IoError> {
    let no_picture = || IoError::unsupported(FORMAT, Place::Whole, "the picture does not fit into memory");
    let mut map = Pixmap::new(s.width.ceil() as u32, s.height.ceil() as u32).ok_or_else(no_picture)?;
    map.fill(Color::WHITE);
    let identity = Transform::identity();
    let lines = Stroke { width: s.line_width as f32, ..Stroke::default() };
    for fill in &s.fills {
        // Pieces of bounded size: the cost of a fill grows faster than its number of edges.
        for part in fill.polygons.chunks(2048) {
            let mut b = PathBuilder::with_capacity(5 * part.len(), 4 * part.len());
            for c in part {
                let (x, y) = xy(c[0]);
                b.move_to(x, y);
                for &p in &c[1..] {
                    let (x, y) = xy(p);
                    b.line_to(x, y);
                }
                b.close();
            }
            // Without lines between them, smooth edges would leave white seams.
            if let Some(path) = b.finish() {
                map.fill_path(
                    &path,
                    &paint(fill.colour, s.line_width > 0.0),
                    FillRule::Winding,
                    identity,
                    None,
                );
                if s.line_width > 0.0 {
                    map.stroke_path(&path, &paint([51, 51, 51], true), &lines, identity, None);
                }
            }
        }
        thick(&mut map, &fill.lines, s.outline_width);
    }
    thick(&mut map, &s.outline, s.outline_width);
    for &p in &s.dots {
        let (x, y) = xy(p);
        if let Some(path) = PathBuilder::from_circle(x, y, s.dot_radius as f32) {
            map.fill_path(&path, &paint([192, 0, 0], true), FillRule::Winding, identity, None);
        }
    }
    for ([x, y, bw, bh], colour) in &s.bar {
        if let Some(r) = Rect::from_xywh(*x as f32, *y as f32, *bw as f32, (*bh + 0.3) as f32) {
            map.fill_rect(r, &paint(*colour, false), identity, None);
        }
    }
    let pen = Stroke { width: 1.1, ..Stroke::default() };
    for (at, text) in &s.labels {
        if let Some(path) = label(text, *at) {
            map.stroke_path(&path, &paint([0, 0, 0], true), &pen, identity, None);
        }
    }
    let bytes = map.encode_png().map_err(|e| IoError::unsupported(FORMAT, Place::Whole, e.to_string()))?;
    Ok(w.write_all(&bytes)?)
}

/// Thick black lines.
fn thick(map: &mut Pixmap, lines: &[[[f64; 2]; 2]], width: f64) {
    let stroke = Stroke { width: width as f32, line_cap: LineCap::Round, ..Stroke::default() };
    for part in lines.chunks(2048) {
        let mut b = PathBuilder::new();
        for &[p, q] in part {
            let ((px, py), (qx, qy)) = (xy(p), xy(q));
            b.move_to(px, py);
            b.line_to(qx, qy);
        }
        if let Some(path) = b.finish() {
            map.stroke_path(&path, &paint([0, 0, 0], true), &stroke, Transform::identity(), None);
        }
    }
}
