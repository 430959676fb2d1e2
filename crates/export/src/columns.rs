//! The columns of tables that have a row for each body and frame.

/// One of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Column {
    Frame,
    Time,
    Id,
    Name,
    Shape,
    Scale,
    /// In the world: metres along an axis.
    Position(usize),
    /// A component of the quaternion.
    Rotation(usize),
    /// m/s along an axis.
    Velocity(usize),
    /// rad/s about an axis.
    Spin(usize),
}

/// All of them with their names, of which units are a part.
pub(crate) const COLUMNS: [(&str, Column); 19] = [
    ("frame", Column::Frame),
    ("time_s", Column::Time),
    ("id", Column::Id),
    ("name", Column::Name),
    ("shape", Column::Shape),
    ("scale", Column::Scale),
    ("x_m", Column::Position(0)),
    ("y_m", Column::Position(1)),
    ("z_m", Column::Position(2)),
    ("qx", Column::Rotation(0)),
    ("qy", Column::Rotation(1)),
    ("qz", Column::Rotation(2)),
    ("qw", Column::Rotation(3)),
    ("vx_m_s", Column::Velocity(0)),
    ("vy_m_s", Column::Velocity(1)),
    ("vz_m_s", Column::Velocity(2)),
    ("wx_rad_s", Column::Spin(0)),
    ("wy_rad_s", Column::Spin(1)),
    ("wz_rad_s", Column::Spin(2)),
];
