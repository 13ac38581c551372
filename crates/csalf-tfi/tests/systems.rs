//! Chord systems of the table: worked numbers of handbook A.12 - A.15.

use csalf_tfi::pattern::Pattern;
use csalf_tfi::table::patterns;

fn solutions(p: &Pattern, sides: &[u32]) -> Vec<Vec<u32>> {
    let mut out = Vec::new();
    p.solve(sides, 2, 1000, &mut |x| out.push(x[..p.n_chords].to_vec()));
    out
}

fn get(n: usize, name: &str) -> &'static Pattern {
    patterns(n).iter().find(|p| p.name == name).expect("it is in the table")
}

#[test]
fn triangle_half_perimeter() {
    let t = get(3, "tri");
    let x = solutions(t, &[10, 8, 6]);
    assert_eq!(x.len(), 1);
    let mut x = x[0].clone();
    x.sort_unstable();
    assert_eq!(x, [2, 4, 6]);
    assert!(solutions(t, &[10, 5, 5]).is_empty());
    assert!(solutions(t, &[10, 8, 7]).is_empty());
}

#[test]
fn pentagon_spokes() {
    let p = get(5, "pent");
    let x = solutions(p, &[5, 5, 4, 5, 5]);
    assert_eq!(x.len(), 1);
    let mut x = x[0].clone();
    x.sort_unstable();
    assert_eq!(x, [2, 2, 2, 3, 3]);
}

#[test]
fn disk_counts() {
    let p = get(0, "disk");
    let x = solutions(p, &[12; 4]);
    assert_eq!(x.len(), 1);
    let mut c = [0; csalf_tfi::pattern::MAX_CHORDS];
    c[..p.n_chords].copy_from_slice(&x[0]);
    assert_eq!(p.n_quads(&c), 240);
}
