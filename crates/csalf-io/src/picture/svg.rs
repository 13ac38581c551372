//! Draws the scene as SVG: one path per colour.

use super::Shade;
use super::scene::{Rgb, Scene};
use crate::{IoError, MeshView};
use std::io::Write;

/// Hundredths of a pixel are fine enough; fewer digits make smaller files.
fn px(x: f64) -> f64 {
    (x * 100.0).round() / 100.0
}

fn hex([r, g, b]: Rgb) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// Writes a picture of a mesh.
///
/// # Errors
/// [`IoError::Write`]; [`IoError::Unsupported`](IoError) if the mesh is broken.
pub fn write_svg(out: &MeshView<'_>, w: &mut dyn Write) -> Result<(), IoError> {
    draw(&Scene::new(out, None)?, out.title, w)
}

/// Writes a picture of a mesh, coloured by `shade`.
///
/// # Errors
/// As [`write_svg`]; [`IoError::Unsupported`] also if there is not one value per element.
pub fn write_svg_by(out: &MeshView<'_>, shade: &Shade<'_>, w: &mut dyn Write) -> Result<(), IoError> {
    draw(&Scene::new(out, Some(shade))?, out.title, w)
}

fn draw(s: &Scene, title: &str, w: &mut dyn Write) -> Result<(), IoError> {
    let (width, height) = (s.width.ceil(), s.height.ceil());
    writeln!(
        w,
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
         viewBox=\"0 0 {width} {height}\">"
    )?;
    let title = crate::text::one_line(title).replace('&', "&amp;").replace('<', "&lt;");
    writeln!(w, "<title>{title}</title>\n<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>")?;
    let stroke = if s.line_width > 0.0 {
        format!("stroke=\"#333\" stroke-width=\"{}\" stroke-linejoin=\"round\"", px(s.line_width))
    } else {
        "shape-rendering=\"crispEdges\"".to_owned()
    };
    writeln!(w, "<g {stroke}>")?;
    for fill in &s.fills {
        write!(w, "<path fill=\"{}\" d=\"", hex(fill.colour))?;
        for c in &fill.polygons {
            let [a, b, c, d] = c.map(|[x, y]| [px(x), px(y)]);
            write!(w, "M{} {}L{} {} {} {}", a[0], a[1], b[0], b[1], c[0], c[1])?;
            if c != d {
                write!(w, " {} {}", d[0], d[1])?;
            }
            write!(w, "z")?;
        }
        writeln!(w, "\"/>")?;
        thick(&fill.lines, s.outline_width, w)?;
    }
    writeln!(w, "</g>")?;
    thick(&s.outline, s.outline_width, w)?;
    if !s.dots.is_empty() {
        writeln!(w, "<g fill=\"#c00000\">")?;
        for [x, y] in &s.dots {
            writeln!(w, "<circle cx=\"{}\" cy=\"{}\" r=\"{}\"/>", px(*x), px(*y), px(s.dot_radius))?;
        }
        writeln!(w, "</g>")?;
    }
    for ([x, y, bw, bh], colour) in &s.bar {
        // A hair of overlap hides the joints.
        let (x, y, h) = (px(*x), px(*y), px(bh + 0.3));
        writeln!(w, "<rect x=\"{x}\" y=\"{y}\" width=\"{bw}\" height=\"{h}\" fill=\"{}\"/>", hex(*colour))?;
    }
    for ([x, y], label) in &s.labels {
        let (x, y) = (px(*x), px(y + 4.0));
        writeln!(w, "<text x=\"{x}\" y=\"{y}\" font-family=\"sans-serif\" font-size=\"11\">{label}</text>")?;
    }
    writeln!(w, "</svg>")?;
    Ok(())
}

/// Thick lines as one path.
fn thick(lines: &[[[f64; 2]; 2]], width: f64, w: &mut dyn Write) -> Result<(), IoError> {
    if lines.is_empty() {
        return Ok(());
    }
    write!(w, "<path fill=\"none\" stroke=\"#000\" stroke-width=\"{width}\" stroke-linecap=\"round\" d=\"")?;
    for [a, b] in lines {
        write!(w, "M{} {}L{} {}", px(a[0]), px(a[1]), px(b[0]), px(b[1]))?;
    }
    Ok(writeln!(w, "\"/>")?)
}
