//! Maps of points that may stretch, named by where they lead: `scene_from_object`.

use glam::{DMat3, DVec3};

use super::rigid::DRigid;

/// `x -> linear x + translation`; f64. It never mirrors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DAffine {
    /// Columns are the images of the axes.
    pub linear: DMat3,
    /// Image of the origin.
    pub translation: DVec3,
    /// The factor by which all lengths grow, exactly 1 for rotations; `None` if directions differ.
    pub growth: Option<f64>,
}

impl From<DRigid> for DAffine {
    fn from(rigid: DRigid) -> Self {
        let DRigid { rotation, translation } = rigid;
        Self { linear: rotation, translation, growth: Some(1.0) }
    }
}

impl DAffine {
    /// Moves nothing.
    pub const IDENTITY: Self =
        Self { linear: DMat3::IDENTITY, translation: DVec3::ZERO, growth: Some(1.0) };

    /// Scales along the axes first, then turns and moves.
    pub fn scaled(scale: DVec3, rigid: DRigid) -> Self {
        let DMat3 { x_axis, y_axis, z_axis } = rigid.rotation;
        let growth = (scale == DVec3::splat(scale.x)).then_some(scale.x);
        let linear = DMat3::from_cols(x_axis * scale.x, y_axis * scale.y, z_axis * scale.z);
        Self { linear, translation: rigid.translation, growth }
    }

    /// Whether it turns and moves only.
    pub fn is_rigid(&self) -> bool {
        self.growth == Some(1.0)
    }

    /// Image of a point.
    pub fn point(&self, p: DVec3) -> DVec3 {
        self.linear * p + self.translation
    }

    /// The image of a length, if the map grows by the same factor in all directions.
    pub fn length(&self, length: f64) -> f64 {
        length * self.growth.unwrap_or(1.0)
    }

    /// The image of a unit vector, at length 1, if the map grows by the same factor in all
    /// directions.
    pub fn direction(&self, v: DVec3) -> DVec3 {
        let image = self.linear * v;
        if self.is_rigid() { image } else { image.normalize_or(v) }
    }

    /// The map that applies `first`, then this one.
    #[must_use]
    pub fn after(&self, first: &Self) -> Self {
        Self {
            linear: self.linear * first.linear,
            translation: self.point(first.translation),
            growth: self.growth.zip(first.growth).map(|(a, b)| a * b),
        }
    }

    /// The map whose origin lies at `center`: what it does to `center + x`.
    #[must_use]
    pub fn about(&self, center: DVec3) -> Self {
        Self { translation: self.point(center), ..*self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_product_applies_one_after_the_other() {
        let quarter = DMat3::from_cols(DVec3::Y, DVec3::NEG_X, DVec3::Z);
        let turned = DRigid { rotation: quarter, translation: DVec3::new(1.0, 2.0, 3.0) };
        let outer = DAffine::scaled(DVec3::new(2.0, 1.0, 1.0), turned);
        let inner = DAffine::scaled(DVec3::splat(3.0), turned);
        let p = DVec3::new(0.5, -1.0, 4.0);
        // inner: (3 * -(-1), 3 * 0.5, 12) + (1, 2, 3) turned = (3, 1.5, 12) + (1, 2, 3)
        assert_eq!(inner.point(p), DVec3::new(4.0, 3.5, 15.0));
        // outer: scaled to (8, 3.5, 15), turned to (-3.5, 8, 15)
        assert_eq!(outer.point(inner.point(p)), DVec3::new(-2.5, 10.0, 18.0));
        let both = outer.after(&inner);
        assert_eq!(both.point(p), DVec3::new(-2.5, 10.0, 18.0));
        assert_eq!((both.growth, inner.after(&inner).growth), (None, Some(9.0)));
        assert!(DAffine::from(turned).after(&DAffine::from(turned)).is_rigid());
        assert_eq!(both.about(p).point(DVec3::ZERO), both.point(p));
    }
}
