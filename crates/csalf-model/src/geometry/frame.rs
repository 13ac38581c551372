//! A right-handed orthonormal frame: where an analytic curve or surface stands.

use glam::DVec3;

/// Origin and three unit axes, right-handed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// Where the frame stands.
    pub origin: DVec3,
    /// First axis: where angles are zero.
    pub x: DVec3,
    /// Second axis, `z × x`.
    pub y: DVec3,
    /// Third axis: the axis of revolution, or the normal of a plane.
    pub z: DVec3,
}

impl Frame {
    /// The axes of the model.
    pub const WORLD: Self = Self { origin: DVec3::ZERO, x: DVec3::X, y: DVec3::Y, z: DVec3::Z };

    /// A frame with this axis and, as far as it is not parallel to it, this reference direction. What is missing,
    /// zero or not finite is replaced: the axis by z, the reference by any direction square to the axis.
    pub fn new(origin: DVec3, axis: DVec3, reference: DVec3) -> Self {
        let z = axis.try_normalize().unwrap_or(DVec3::Z);
        // Lengths below this share of the reference direction are rounding: the two are parallel.
        const PARALLEL: f64 = 1e-9;
        let across = reference - z * reference.dot(z);
        let usable = across.length() > PARALLEL * reference.length();
        let x =
            if usable { across.try_normalize() } else { None }.unwrap_or_else(|| z.any_orthonormal_vector());
        Self { origin, x, y: z.cross(x), z }
    }

    /// The point with these coordinates in the frame.
    pub fn point(&self, x: f64, y: f64, z: f64) -> DVec3 {
        self.origin + self.x * x + self.y * y + self.z * z
    }

    /// The coordinates of a point in the frame.
    pub fn local(&self, p: DVec3) -> DVec3 {
        let d = p - self.origin;
        DVec3::new(d.dot(self.x), d.dot(self.y), d.dot(self.z))
    }

    /// The unit vector at angle `a` (radians) in the frame's x, y plane, and its derivative by `a`.
    pub fn circle(&self, a: f64) -> (DVec3, DVec3) {
        let (s, c) = a.sin_cos();
        (self.x * c + self.y * s, self.y * c - self.x * s)
    }

    /// The frame moved by a rigid motion.
    pub fn moved(&self, by: &Motion) -> Self {
        Self {
            origin: by.point(self.origin),
            x: by.vector(self.x),
            y: by.vector(self.y),
            z: by.vector(self.z),
        }
    }
}

/// A rigid motion: a rotation, then a shift. Places an instance of a part in an assembly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// The frame that the model's axes go to.
    pub to: Frame,
}

impl Motion {
    /// Nothing moves.
    pub const IDENTITY: Self = Self { to: Frame::WORLD };

    /// Where a point goes.
    pub fn point(&self, p: DVec3) -> DVec3 {
        self.to.point(p.x, p.y, p.z)
    }

    /// Where a direction goes.
    pub fn vector(&self, v: DVec3) -> DVec3 {
        self.to.x * v.x + self.to.y * v.y + self.to.z * v.z
    }

    /// This motion after `first`.
    pub fn after(&self, first: &Self) -> Self {
        Self { to: first.to.moved(self) }
    }
}
