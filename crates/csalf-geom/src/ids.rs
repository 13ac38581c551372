//! Typed `u32` indices. They print as `v12`, `q7`; no arithmetic is defined on them.

/// Makes a `u32` newtype index.
macro_rules! define_id {
    ($(#[$doc:meta])* $name:ident, $letter:literal) => {
        $(#[$doc])*
        #[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
        #[repr(transparent)]
        pub struct $name(pub u32);

        impl $name {
            /// The id of entry `i`. Panics in debug builds if `i` does not fit 32 bits.
            #[inline]
            pub const fn new(i: usize) -> Self {
                debug_assert!(i <= u32::MAX as usize, "index exceeds 32 bits");
                Self(i as u32)
            }
            /// The position that this id stands for.
            #[inline]
            pub const fn index(self) -> usize {
                self.0 as usize
            }
        }

        impl std::fmt::Debug for $name {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                write!(f, concat!($letter, "{}"), self.0)
            }
        }

        impl std::fmt::Display for $name {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                write!(f, concat!($letter, "{}"), self.0)
            }
        }
    };
}

define_id!(
    /// A vertex of a mesh; the nodes of the input come first, in input order.
    VertexId, "v"
);
define_id!(
    /// A quad of a mesh.
    QuadId, "q"
);
