//! Times subdivision alone on a disk. Usage: speed N
use csalf_geom::{Point2, Tolerance};
use csalf_mesh::{Contour, RegionTask};
use csalf_sizemap::Uniform;
use csalf_subdiv::{SplitRules, Subdivision};
fn main() {
    for n in [50usize, 100, 200, 400, 1000, 2000] {
        let r = n as f64 / std::f64::consts::TAU;
        let ring: Vec<_> = (0..n)
            .map(|i| std::f64::consts::TAU * i as f64 / n as f64)
            .map(|t| Point2::new(r * t.cos(), r * t.sin()))
            .collect();
        let c = Contour::from_ring(&ring, 1.0);
        let size = Uniform(1.0);
        let task =
            RegionTask { contour: &c, size: &size, tolerance: Tolerance::of_points(ring.iter().copied()) };
        let t = std::time::Instant::now();
        let (p, tally) =
            Subdivision::new(SplitRules::QUALITY).with_seam(100_000).mesh_with_tally(&task).unwrap();
        let s = t.elapsed().as_secs_f64();
        #[allow(clippy::print_stdout, reason = "example")]
        {
            println!(
                "{n} nodes {} quads {:.3} s {:.2} us/quad {tally:?}",
                p.quads.len(),
                s,
                1e6 * s / p.quads.len() as f64
            );
        }
        if n == 400 {
            let mut sizes = std::collections::BTreeMap::new();
            for ch in &p.children {
                *sizes.entry(ch.len()).or_insert(0) += 1;
            }
            println!("{sizes:?}");
            for ch in p.children.iter().take(6) {
                println!(
                    "{:?}",
                    ch.iter()
                        .map(|&v| {
                            let q = p.point(&c, v);
                            ((q.x * 100.).round() / 100., (q.y * 100.).round() / 100.)
                        })
                        .collect::<Vec<_>>()
                );
            }
        }
    }
}
