//! Wall and processor time of one call.

use cpu_time::ProcessTime;
use std::time::Instant;

/// Seconds that a call took.
#[derive(Clone, Copy, Debug, Default)]
pub struct Seconds {
    /// On the clock on the wall.
    pub wall: f64,
    /// Of all threads of this process together. NaN where the system does not tell.
    pub cpu: f64,
}

/// The most memory that this process held at one time, in megabytes; `None` where the system does not tell.
pub fn peak_memory_mb() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"))?;
    let kilobytes: f64 = line.trim().trim_end_matches("kB").trim().parse().ok()?;
    Some(kilobytes / 1024.0)
}

/// Runs `f` and measures it.
pub fn timed<T>(f: impl FnOnce() -> T) -> (T, Seconds) {
    let (wall, cpu) = (Instant::now(), ProcessTime::try_now().ok());
    let value = f();
    let cpu = cpu.and_then(|c| c.try_elapsed().ok()).map_or(f64::NAN, |d| d.as_secs_f64());
    (value, Seconds { wall: wall.elapsed().as_secs_f64(), cpu })
}
