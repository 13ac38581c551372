//! How the mesher works; the defaults are what most users want.

/// Which of the paper's methods drives the mesher.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Method {
    /// Layers, then the triad with patterns: the best meshes.
    #[default]
    Csalf,
    /// The paper's flow, letter for letter: TFI if convex, mappable and ESG <= 1.2; else pave; else split.
    Paper,
    /// Recursive subdivision alone (TriQuaMesh), the paper's comparison.
    Tqm,
}

/// How much work is put into quality.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Preset {
    /// Lookahead, cleaning, optimisation.
    #[default]
    Quality,
    /// Neither lookahead nor cleaning.
    Fast,
}

/// Options of one run.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Options {
    /// Method.
    pub method: Method,
    /// Preset.
    pub preset: Preset,
    /// Worker threads; 0: as many as there are cores. The mesh does not depend on it.
    pub threads: usize,
    /// Largest growth |grad h| of the size field; `None`: the field as given.
    pub gradation: Option<f64>,
    /// Allow triangles (quad-dominant) where a region has an odd number of segments.
    pub allow_triangles: bool,
    /// Allow one node to be added to a scar that cuts off an odd region.
    pub repair_parity: bool,
}
