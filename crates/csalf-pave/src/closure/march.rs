//! The sequential march: one front after the other, then the closure stencil.
//!
//! 1. The first front is opened: rays, corner quads, and a stand-in where it needs a node of A.
//! 2. Every further front takes P, the last ray of the front before, makes its own rays and the quads on AB and at
//!    its corner. After a corner the first ray is the shared node. The march looks one front ahead, since a front
//!    beside an acute one makes a single ray or none.
//! 3. The [`stencil`] of the first and last front closes the ring.
//!
//! Cost O(n). Source: paper, section 4.2, Tables I and II; handbook 2.5.

use super::stencil::{Name, NamedQuad, opening, stencil};
use crate::Front;
use crate::ring::{Role, settle};
use std::collections::BTreeMap;

/// What a march made, in names `i < n` for nodes of the loop and `n + k` for new ones, in order of making. Numbers
/// of nodes that were replaced or dropped are not used.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Closed {
    /// The ring.
    Ring {
        /// Rays of every node of the loop, in order.
        rays: Vec<Vec<u32>>,
        /// The quads.
        quads: Vec<[u32; 4]>,
    },
    /// First and last front are both corners: this quad is peeled off, and the loop without its two middle nodes
    /// begins anew.
    Peel([u32; 4]),
}

struct March {
    next: u32,
    rays: Vec<Vec<u32>>,
    quads: Vec<[u32; 4]>,
}

impl March {
    fn fresh(&mut self) -> u32 {
        self.next += 1;
        self.next - 1
    }

    /// Advances the front at `i` with `rays` rays, the first of which is `shared` after a corner.
    fn advance(&mut self, i: usize, role: Role, shared: Option<u32>) {
        let mut own: Vec<u32> = Vec::with_capacity(5);
        for m in 0..role.rays() {
            let v = match shared {
                Some(v) if m == 0 => v,
                _ => self.fresh(),
            };
            own.push(v);
        }
        let b = i as u32;
        match role {
            Role::RightReversal => self.quads.push([b, own[2], own[1], own[0]]),
            Role::Reversal => self.quads.extend([[b, own[2], own[1], own[0]], [b, own[4], own[3], own[2]]]),
            _ => {}
        }
        self.rays[i] = own;
    }
}

/// The front that a node makes when the edge on its inner side (away from the seam) stays uncovered.
fn effective(front: Front, uncovered: bool) -> Front {
    match front {
        _ if !uncovered => front,
        Front::Acute | Front::Right | Front::Obtuse => Front::Acute,
        _ => Front::Flat,
    }
}

/// Marches around a loop of these fronts, from node 0 to node n - 1. Inner corners must not be adjacent, and n must
/// be at least 4.
pub fn march(fronts: &[Front]) -> Closed {
    let n = fronts.len();
    let settled = |neutral: Option<usize>| {
        let mut f = fronts.to_vec();
        if let Some(i) = neutral {
            f[i] = Front::Flat;
        }
        let mut cover = vec![true; n];
        (settle(&f, &mut cover, |_| true), cover)
    };
    // What acute fronts within the march do to the first and last front is seen in time; what first and last do
    // to each other is the stencil's business.
    let first = effective(fronts[0], !settled(Some(n - 1)).1[0]);
    let last = effective(fronts[n - 1], !settled(Some(0)).1[n - 2]);
    let (roles, cover) = settled(None);
    let cell = stencil(first, last);
    if cell.peel {
        return Closed::Peel([n as u32 - 2, n as u32 - 1, 0, 1]);
    }
    let mut m = March { next: n as u32, rays: vec![Vec::new(); n], quads: Vec::new() };
    let mut names: BTreeMap<Name, u32> =
        [(Name::X, n - 2), (Name::A, n - 1), (Name::B, 0), (Name::C, 1)].map(|(k, i)| (k, i as u32)).into();

    // 1. Open.
    let (opened, nodes) = opening(first);
    for v in nodes {
        let id = m.fresh();
        names.insert(v, id);
    }
    let own: &[Name] = match first {
        Front::Acute | Front::Right | Front::Obtuse => &[],
        Front::Flat => &[Name::Q2],
        Front::RightReversal => &[Name::R2, Name::S2, Name::Q2],
        Front::Reversal => &[Name::R2, Name::S2, Name::T2, Name::U2, Name::Q2],
    };
    m.rays[0] = own.iter().map(|v| names[v]).collect();
    let shared_first = first.is_corner().then(|| names[&Name::Q2]);

    // 2. March.
    for i in 1..n - 1 {
        let before = i - 1;
        let shared = match before {
            // The shared node of the opening; C keeps it even if the stencil withdraws the quad.
            0 => shared_first,
            _ if roles[before] == Role::Corner => m.rays[before - 1].last().copied(),
            _ => None,
        };
        m.advance(i, roles[i], shared);
        // Beyond a corner the edge has its quad already; the corner's rays are empty.
        if let (true, Some(&p)) = (cover[before], m.rays[before].last()) {
            let end = if roles[i] == Role::Corner { i as u32 + 1 } else { m.rays[i][0] };
            m.quads.push([before as u32, i as u32, end, p]);
        }
    }
    close(m, &mut names, &cell, &roles, &opened)
}

/// 3. The stencil.
fn close(
    mut m: March,
    names: &mut BTreeMap<Name, u32>,
    cell: &super::Stencil,
    roles: &[Role],
    opened: &[NamedQuad],
) -> Closed {
    let n = roles.len();
    let after_corner = roles[n - 2] == Role::Corner;
    let p = if after_corner { m.rays[n - 3].last() } else { m.rays[n - 2].last() };
    if let Some(&p) = p {
        names.insert(Name::P, p);
    }
    let letters: &[Name] = match roles[n - 1] {
        Role::Blocked | Role::Corner => &[],
        Role::Start | Role::End | Role::Flat => &[Name::Q],
        Role::RightReversal => &[Name::R, Name::S, Name::Q],
        Role::Reversal => &[Name::R, Name::S, Name::T, Name::U, Name::Q],
    };
    for (k, v) in letters.iter().enumerate() {
        let id = match names.get(&Name::P) {
            // After a corner the first ray is the shared node.
            Some(&p) if k == 0 && after_corner => p,
            _ => m.fresh(),
        };
        names.insert(*v, id);
    }
    m.rays[n - 1] = letters.iter().map(|v| names[v]).collect();
    let xa_open = matches!(roles[n - 2], Role::Blocked | Role::End);
    let mut quads: Vec<NamedQuad> = opened.iter().filter(|q| !cell.withdraw.contains(q)).copied().collect();
    for (old, new) in &cell.change {
        for q in quads.iter_mut().filter(|q| *q == old) {
            *q = *new;
        }
    }
    for q in &cell.create {
        let on_xa = q[0] == Name::X && q[2] != Name::B;
        // XA has its quad already if X is a corner, and none if it is uncovered.
        if !(on_xa && (after_corner || xa_open)) {
            quads.push(*q);
        }
    }
    for q in quads {
        m.quads.push(q.map(|v| names[&v]));
    }
    match roles[0] {
        Role::Start => m.rays[0] = vec![names[&Name::Q2]],
        Role::Blocked => m.rays[0].clear(),
        _ => {}
    }
    for (gone, kept) in &cell.merge {
        if let (Some(&gone), Some(&kept)) = (names.get(gone), names.get(kept)) {
            m.rays.iter_mut().flatten().for_each(|v| *v = if *v == gone { kept } else { *v });
            m.quads.iter_mut().flatten().for_each(|v| *v = if *v == gone { kept } else { *v });
        }
    }
    Closed::Ring { rays: m.rays, quads: m.quads }
}
