//! Seconds for the report. WebAssembly without a host has no clock: there all times are 0.

/// Seconds since the first call in this process.
#[cfg(not(target_family = "wasm"))]
pub(crate) fn now() -> f64 {
    static FIRST: std::sync::LazyLock<std::time::Instant> = std::sync::LazyLock::new(std::time::Instant::now);
    FIRST.elapsed().as_secs_f64()
}

/// Nobody knows.
#[cfg(target_family = "wasm")]
pub(crate) fn now() -> f64 {
    0.0
}
