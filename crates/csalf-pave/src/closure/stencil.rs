//! The closure stencils of Table II, one per pair of first and last front.

use crate::Front;

/// A node in the paper's letters.
#[derive(Clone, Copy, PartialEq, Eq, Debug, PartialOrd, Ord, Hash)]
pub enum Name {
    /// The node before the last front.
    X,
    /// Node of the last front.
    A,
    /// Node of the first front.
    B,
    /// The node after the first front.
    C,
    /// Last ray of X.
    P,
    /// First ray of the last front's diagonal corner (C and R fronts).
    R,
    /// Diagonal node.
    S,
    /// Middle ray of a reversal.
    T,
    /// Second diagonal node of a reversal.
    U,
    /// Last ray of the last front, the only one of a flat front.
    Q,
    /// Stand-in for a node of A, made by a first front that is a right reversal or reversal.
    P2,
    /// First ray of the first front: its only one if flat.
    R2,
    /// Diagonal node of the first front.
    S2,
    /// Middle ray of a first front that is a reversal.
    T2,
    /// Second diagonal node of a first front that is a reversal.
    U2,
    /// Last ray of the first front; of a corner the node it would share.
    Q2,
}

impl Name {
    /// As the paper writes it.
    pub const fn text(self) -> &'static str {
        match self {
            Self::X => "X",
            Self::A => "A",
            Self::B => "B",
            Self::C => "C",
            Self::P => "P",
            Self::R => "R",
            Self::S => "S",
            Self::T => "T",
            Self::U => "U",
            Self::Q => "Q",
            Self::P2 => "P\"",
            Self::R2 => "R\"",
            Self::S2 => "S\"",
            Self::T2 => "T\"",
            Self::U2 => "U\"",
            Self::Q2 => "Q\"",
        }
    }
}

/// A quad in the paper's letters, counter-clockwise.
pub type NamedQuad = [Name; 4];

/// One cell of Table II.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Stencil {
    /// Quads that the first front made by itself, when nothing was known of the last.
    pub opening: Vec<NamedQuad>,
    /// Quads to create.
    pub create: Vec<NamedQuad>,
    /// Quads of the opening that change, old and new.
    pub change: Vec<(NamedQuad, NamedQuad)>,
    /// Quads of the opening to be withdrawn.
    pub withdraw: Vec<NamedQuad>,
    /// Nodes that become one: the first is replaced by the second.
    pub merge: Vec<(Name, Name)>,
    /// Nodes of the opening that vanish.
    pub drop: Vec<Name>,
    /// A and B are both corners: the quad is peeled off and the loop begins anew without them.
    pub peel: bool,
    /// One sentence on what happens.
    pub note: &'static str,
}

/// Quads and new nodes of a first front before anything is known of the last.
pub(crate) fn opening(first: Front) -> (Vec<NamedQuad>, Vec<Name>) {
    use Name::{A, B, C, P2, Q2, R2, S2, T2, U2};
    match first {
        Front::Acute => (vec![], vec![]),
        Front::Right | Front::Obtuse => (vec![[A, B, C, Q2]], vec![Q2]),
        Front::Flat => (vec![], vec![Q2]),
        Front::RightReversal => (vec![[A, B, R2, P2], [B, Q2, S2, R2]], vec![P2, R2, S2, Q2]),
        Front::Reversal => {
            (vec![[A, B, R2, P2], [B, T2, S2, R2], [B, Q2, U2, T2]], vec![P2, R2, S2, T2, U2, Q2])
        }
    }
}

/// The cell of Table II for this pair of fronts, completed and corrected.
pub fn stencil(first: Front, last: Front) -> Stencil {
    use Name::{A, B, C, P, P2, Q, Q2, R, R2, S, T, U, X};
    let (opening, nodes) = opening(first);
    let mut s = Stencil { opening, ..Stencil::default() };
    let provisional = [A, B, R2, P2];
    let reversal = matches!(first, Front::RightReversal | Front::Reversal);
    // First ray of the first front: where the quad on AB ends.
    let b1 = if reversal { R2 } else { Q2 };

    if first == Front::Acute {
        match last {
            Front::Acute => s.note = "Neither front builds anything; XA, AB and BC stay on the new loop.",
            Front::Right | Front::Obtuse => s.note = "A has no second edge to share: it is blocked as well.",
            _ => {
                s.create.push([X, A, Q, P]);
                s.note = "A ends the chain with the single ray Q; AB stays on the new loop.";
            }
        }
        return s;
    }
    if last == Front::Acute {
        s.withdraw = s.opening.clone();
        if first.is_corner() {
            s.note =
                "B has no second edge to share: its quad is withdrawn, B is blocked, C starts the chain.";
        } else {
            s.drop = nodes.into_iter().filter(|&v| v != Q2).collect();
            s.note = "B starts the chain with the single ray Q\"; AB stays on the new loop.";
        }
        return s;
    }
    // The quads on XA and round A.
    let q_first = if last == Front::Flat { Q } else { R };
    if last.is_corner() {
        if first.is_corner() {
            s.create.push([X, A, B, C]);
            s.withdraw = s.opening.clone();
            s.merge.push((Q2, X));
            s.peel = true;
            s.note = "The finger is one quad wide: XABC closes it, Q\" is replaced by X.";
            return s;
        }
        if reversal {
            s.change.push((provisional, [X, A, B, R2]));
            s.drop.push(P2);
        } else {
            s.create.push([X, A, B, b1]);
        }
        s.merge.push((P, b1));
        s.note = "X and B share one node.";
        return s;
    }
    s.create.push([X, A, q_first, P]);
    if last == Front::RightReversal {
        s.create.push([A, Q, S, R]);
    }
    if last == Front::Reversal {
        s.create.extend([[A, T, S, R], [A, Q, U, T]]);
    }
    if first.is_corner() {
        s.change.push(([A, B, C, Q2], [A, B, C, Q]));
        s.merge.push((Q2, Q));
        s.note = "A and C share one node.";
    } else if reversal {
        s.change.push((provisional, [A, B, R2, Q]));
        s.merge.push((P2, Q));
        s.note = "The stand-in P\" becomes Q.";
    } else {
        s.create.push([A, B, Q2, Q]);
        s.note = "The quad on AB joins the two fronts.";
    }
    s
}
