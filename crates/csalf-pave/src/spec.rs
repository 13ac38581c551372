//! What a caller may ask of the layers of one loop.

/// How the thickness of a layer follows from its number i = 0, 1, ... and the first thickness t0.
#[derive(Clone, Debug, PartialEq, Default)]
pub enum LayerLaw {
    /// Isotropic growth: each layer as thick as its quads are long.
    #[default]
    Auto,
    /// t0, t0, t0, ...
    Constant,
    /// t0 (1 + i).
    Ramp,
    /// t0 (1 + r i²), r chosen so that the last layer meets the size field.
    Parabolic,
    /// t0 times 1, 1, 2, 3, 5, 8, ...
    Fibonacci,
    /// t0 q^i.
    Geometric(f64),
    /// The thicknesses themselves, one per layer.
    Explicit(Vec<f64>),
}

/// The layers asked for around one loop.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct LayerSpec {
    /// Number of layers; 0 forbids them.
    pub count: usize,
    /// Thickness law.
    pub law: LayerLaw,
    /// First thickness t0; `None`: the mean segment length of the loop.
    pub first: Option<f64>,
}
