//! The loop fronts of Table I: what is built at one node of a loop.
//!
//! ```text
//!  Flat (S)              Right, Obtuse (E)      RightReversal (C)      Reversal (R, slit tip)
//!  P-----Q-----Q'        A-----P                P-----R-----S          P-----R-----S
//!  | AB  | BC  |         | ABC |                | AB  | c1  |          | AB  | c1  |
//!  A-----B-----C         B-----C                A-----B-----Q          A=C---B-----T
//!                                                     | BC  |          | BC  | c2  |
//!                                                     C-----*          *-----Q-----U
//! ```
//!
//! A *front* belongs to node B with its neighbours A before and C after it; material lies on the left. Its rays run
//! from B into the material, named from the side of BA to the side of BC. The acute front builds nothing: the edges
//! AB and BC stay on the new loop. Source: paper, Table I; handbook 2.1.

/// The paper's loop-front types.
#[derive(Clone, Copy, PartialEq, Eq, Debug, PartialOrd, Ord, Hash)]
pub enum Front {
    /// Too sharp for a layer (K): no rays, both edges at the node stay uncovered.
    Acute,
    /// About 90 degrees (E): the two edges share one quad, the neighbours share one new node.
    Right,
    /// Between right and flat, served with one quad (E).
    Obtuse,
    /// About 180 degrees (S): one ray.
    Flat,
    /// About 270 degrees (C): two rays, one diagonal node, one extra quad.
    RightReversal,
    /// About 360 degrees (R): three rays, two diagonal nodes, two extra quads.
    Reversal,
}

impl Front {
    /// New nodes that the front brings, shared ones not counted.
    #[inline]
    pub const fn rays(self) -> usize {
        match self {
            Self::Acute | Self::Right | Self::Obtuse => 0,
            Self::Flat => 1,
            Self::RightReversal => 3,
            Self::Reversal => 5,
        }
    }

    /// Quads at the node besides those on its two edges.
    #[inline]
    pub const fn corner_quads(self) -> usize {
        match self {
            Self::RightReversal => 1,
            Self::Reversal => 2,
            _ => 0,
        }
    }

    /// True of the fronts whose two edges share one quad (E).
    #[inline]
    pub const fn is_corner(self) -> bool {
        matches!(self, Self::Right | Self::Obtuse)
    }

    /// Number k of quads that the layer puts at the node: 0 (K), 1 (E), 2 (S), 3 (C), 4 (R).
    #[inline]
    pub const fn quads_here(self) -> u8 {
        match self {
            Self::Acute => 0,
            Self::Right | Self::Obtuse => 1,
            Self::Flat => 2,
            Self::RightReversal => 3,
            Self::Reversal => 4,
        }
    }

    /// The front of `k` quads at an angle of `theta` radians; `k` is clamped to 0..=4.
    #[inline]
    pub fn of_quads(k: u8, theta: f64) -> Self {
        match k {
            0 => Self::Acute,
            1 if theta < 105f64.to_radians() => Self::Right,
            1 => Self::Obtuse,
            2 => Self::Flat,
            3 => Self::RightReversal,
            _ => Self::Reversal,
        }
    }

    /// One letter for type words: K, E, S, C or R.
    pub const fn letter(self) -> char {
        match self {
            Self::Acute => 'K',
            Self::Right | Self::Obtuse => 'E',
            Self::Flat => 'S',
            Self::RightReversal => 'C',
            Self::Reversal => 'R',
        }
    }

    /// The front of a letter; `None` of any other.
    pub const fn of_letter(c: char) -> Option<Self> {
        Some(match c {
            'K' => Self::Acute,
            'E' => Self::Right,
            'S' => Self::Flat,
            'C' => Self::RightReversal,
            'R' => Self::Reversal,
            _ => return None,
        })
    }
}
