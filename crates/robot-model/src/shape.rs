//! Shapes of links, their volumes and inertias.
//!
//! Closed forms for homogeneous bodies, about the centre of mass, in the shape's axes (any text of mechanics):
//! box `m/3 (b² + c²)` with half extents; sphere `2/5 m r²`; cylinder `m/12 (3 r² + l²)` across, `m/2 r²` along;
//! ellipsoid `m/5 (b² + c²)`; a capsule is a cylinder and two half balls, whose centres of mass lie `3/8 r` outside the
//! cylinder's ends and whose own inertia across is `83/320 m r²`. Meshes: `mesh/volume.rs`.

use crate::mesh::Mesh;
use crate::pose::{Pose, Quaternion, Vector, add, dot, from_axes, matrix, scaled, subtract};

/// A shape on a link.
#[derive(Debug, Clone, PartialEq)]
pub struct Shape {
    /// Its name; empty if it has none.
    pub name: String,
    /// What it is there for.
    pub role: Role,
    /// Its frame (the centre of a primitive) in the frame of the link.
    pub pose_in_link: Pose,
    /// Its form.
    pub geometry: Geometry,
    /// How it rubs; the physics' own default if `None`.
    pub friction: Option<Friction>,
    /// Which shapes it touches; everything if `None`.
    pub mask: Option<Mask>,
    /// Dimensions of contact as MuJoCo counts them (1, 3, 4 or 6), if set.
    pub contact_dimensions: Option<u8>,
    /// Red, green, blue, opacity in [0, 1].
    pub colour: Option<[f64; 4]>,
}

/// What a shape is there for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Role {
    /// To be seen.
    Visual,
    /// To be touched.
    Collision,
}

/// Coulomb friction of a shape's surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Friction {
    /// Coefficient of sliding friction.
    pub sliding: f64,
    /// Torsional friction, metres (MuJoCo's meaning); the default if `None`.
    pub torsional_m: Option<f64>,
    /// Rolling friction, metres (MuJoCo's meaning); the default if `None`.
    pub rolling_m: Option<f64>,
}

/// Two shapes touch if one's `kind` and the other's `touches` have a bit in common.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Mask {
    /// What it is (`contype` of MJCF).
    pub kind: u32,
    /// What it touches (`conaffinity` of MJCF).
    pub touches: u32,
}

/// The form of a shape, centred at the origin of its frame.
#[derive(Debug, Clone, PartialEq)]
pub enum Geometry {
    /// A cuboid.
    Box {
        /// Half the lengths along x, y, z.
        half_extents_m: Vector,
    },
    /// A ball.
    Sphere {
        /// Radius.
        radius_m: f64,
    },
    /// A cylinder about z.
    Cylinder {
        /// Radius.
        radius_m: f64,
        /// Length along z.
        length_m: f64,
    },
    /// A cylinder about z with a half ball at either end.
    Capsule {
        /// Radius.
        radius_m: f64,
        /// Length of the cylinder, without the half balls.
        length_m: f64,
    },
    /// An ellipsoid.
    Ellipsoid {
        /// Half axes along x, y, z.
        radii_m: Vector,
    },
    /// The plane z = 0, solid below. Endless to touch, whatever its size.
    Plane {
        /// Half lengths along x and y that are drawn; 0 for an endless one.
        half_extents_m: [f64; 2],
    },
    /// Triangles; touched by their convex hull.
    Mesh {
        /// Index into [`crate::Model::meshes`].
        mesh: usize,
    },
}

/// Mass and inertia of a link.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Inertial {
    /// Mass.
    pub mass_kg: f64,
    /// Centre of mass in the frame of the link.
    pub centre_m: Vector,
    /// Inertia about the centre of mass in the axes of the link: xx, yy, zz, xy, xz, yz.
    pub tensor_kg_m2: [f64; 6],
}

/// xx, yy, zz, xy, xz, yz as a matrix.
fn full([xx, yy, zz, xy, xz, yz]: [f64; 6]) -> [Vector; 3] {
    [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]
}

/// `R I Rᵀ` for the rotation of `pose`.
pub(crate) fn turned_tensor(tensor: [f64; 6], pose: &Pose) -> [f64; 6] {
    let inner = full(tensor);
    let turn = matrix(pose.rotation);
    let entry = |row: usize, column: usize| {
        let half: Vector =
            std::array::from_fn(|k| (0..3).map(|l| inner[k][l] * turn[column][l]).sum::<f64>());
        dot(turn[row], half)
    };
    [
        entry(0, 0),
        entry(1, 1),
        entry(2, 2),
        entry(0, 1),
        entry(0, 2),
        entry(1, 2),
    ]
}

/// Steiner's term of a mass at `offset`: `m (d² 1 - d dᵀ)`.
fn steiner(mass_kg: f64, d: Vector) -> [f64; 6] {
    let square = dot(d, d);
    [
        mass_kg * (square - d[0] * d[0]),
        mass_kg * (square - d[1] * d[1]),
        mass_kg * (square - d[2] * d[2]),
        -mass_kg * d[0] * d[1],
        -mass_kg * d[0] * d[2],
        -mass_kg * d[1] * d[2],
    ]
}

impl Inertial {
    /// The same body with its frame placed by `pose` in another: centre and tensor in the axes of the outer frame.
    #[must_use]
    pub fn placed(&self, pose: &Pose) -> Self {
        Self {
            mass_kg: self.mass_kg,
            centre_m: pose.apply(self.centre_m),
            tensor_kg_m2: turned_tensor(self.tensor_kg_m2, pose),
        }
    }

    /// Two bodies of one frame, joined.
    #[must_use]
    pub fn joined(&self, other: &Self) -> Self {
        let mass_kg = self.mass_kg + other.mass_kg;
        if mass_kg <= 0.0 {
            return *self;
        }
        let weighted = add(
            scaled(self.centre_m, self.mass_kg),
            scaled(other.centre_m, other.mass_kg),
        );
        let centre_m = scaled(weighted, 1.0 / mass_kg);
        let mut tensor_kg_m2 = [0.0; 6];
        for part in [self, other] {
            let moved = steiner(part.mass_kg, subtract(part.centre_m, centre_m));
            for (sum, (own, moved)) in tensor_kg_m2
                .iter_mut()
                .zip(part.tensor_kg_m2.iter().zip(moved))
            {
                *sum += own + moved;
            }
        }
        Self {
            mass_kg,
            centre_m,
            tensor_kg_m2,
        }
    }

    /// The principal moments, ascending.
    #[must_use]
    pub fn principal_moments_kg_m2(&self) -> Vector {
        let (mut moments, _) = self.principal_axes();
        moments.sort_by(f64::total_cmp);
        moments
    }

    /// The principal moments with the orientation, in the link, of the frame whose axes x, y, z they belong to.
    ///
    /// Jacobi's rotations (C. G. J. Jacobi, 1846; Golub and Van Loan, Matrix Computations, section 8.5), cyclically,
    /// until the products vanish; accurate to rounding, and exact (no turn) for a diagonal tensor.
    #[must_use]
    pub fn principal_axes(&self) -> (Vector, Quaternion) {
        const SWEEPS: usize = 30;
        let mut matrix = full(self.tensor_kg_m2);
        let mut axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        for _ in 0..SWEEPS {
            for (p, q) in [(0, 1), (0, 2), (1, 2)] {
                jacobi_rotation(&mut matrix, &mut axes, p, q);
            }
        }
        let mut rotation = from_axes(axes[0], axes[1], axes[2]);
        if rotation[0] < 0.0 {
            rotation = rotation.map(|x| -x);
        }
        ([matrix[0][0], matrix[1][1], matrix[2][2]], rotation)
    }
}

/// Makes the entry (p, q) of a symmetric matrix zero by a turn, which the axes follow.
fn jacobi_rotation(matrix: &mut [Vector; 3], axes: &mut [Vector; 3], p: usize, q: usize) {
    let product = matrix[p][q];
    if product == 0.0 {
        return;
    }
    let theta = (matrix[q][q] - matrix[p][p]) / (2.0 * product);
    let tangent = theta.signum() / (theta.abs() + theta.hypot(1.0));
    let cosine = 1.0 / tangent.hypot(1.0);
    let sine = tangent * cosine;
    matrix[p][p] -= tangent * product;
    matrix[q][q] += tangent * product;
    matrix[p][q] = 0.0;
    matrix[q][p] = 0.0;
    let r = 3 - p - q;
    let (a, b) = (matrix[r][p], matrix[r][q]);
    matrix[r][p] = cosine * a - sine * b;
    matrix[r][q] = sine * a + cosine * b;
    matrix[p][r] = matrix[r][p];
    matrix[q][r] = matrix[r][q];
    let (first, second) = (axes[p], axes[q]);
    axes[p] = subtract(scaled(first, cosine), scaled(second, sine));
    axes[q] = add(scaled(first, sine), scaled(second, cosine));
}

impl Geometry {
    /// Volume in m³; 0 for planes and for meshes that were not loaded.
    #[must_use]
    pub fn volume_m3(&self, meshes: &[Mesh]) -> f64 {
        use std::f64::consts::PI;
        match self {
            Self::Box { half_extents_m: h } => 8.0 * h[0] * h[1] * h[2],
            Self::Sphere { radius_m: r } => 4.0 / 3.0 * PI * r.powi(3),
            Self::Cylinder { radius_m, length_m } => PI * radius_m * radius_m * length_m,
            Self::Capsule {
                radius_m: r,
                length_m,
            } => PI * r * r * (length_m + 4.0 / 3.0 * r),
            Self::Ellipsoid { radii_m: r } => 4.0 / 3.0 * PI * r[0] * r[1] * r[2],
            Self::Plane { .. } => 0.0,
            Self::Mesh { mesh } => meshes.get(*mesh).map_or(0.0, |mesh| mesh.solid().mass_kg),
        }
    }

    /// Mass, centre and inertia of the homogeneous body of that mass, in the shape's own frame; `None` for what has no
    /// volume.
    #[must_use]
    pub fn inertial(&self, mass_kg: f64, meshes: &[Mesh]) -> Option<Inertial> {
        let diagonal = |x: f64, y: f64, z: f64| Inertial {
            mass_kg,
            centre_m: [0.0; 3],
            tensor_kg_m2: [x, y, z, 0.0, 0.0, 0.0],
        };
        let by_squares = |[a, b, c]: Vector, share: f64| {
            let part = mass_kg * share;
            diagonal(
                part * (b * b + c * c),
                part * (a * a + c * c),
                part * (a * a + b * b),
            )
        };
        Some(match self {
            Self::Box { half_extents_m } => by_squares(*half_extents_m, 1.0 / 3.0),
            Self::Ellipsoid { radii_m } => by_squares(*radii_m, 1.0 / 5.0),
            Self::Sphere { radius_m } => by_squares([*radius_m; 3], 1.0 / 5.0),
            Self::Cylinder {
                radius_m: r,
                length_m: l,
            } => {
                let across = mass_kg / 12.0 * (3.0 * r * r + l * l);
                diagonal(across, across, mass_kg / 2.0 * r * r)
            }
            Self::Capsule { radius_m, length_m } => {
                let (across, along) = capsule_moments(mass_kg, *radius_m, *length_m);
                diagonal(across, across, along)
            }
            Self::Plane { .. } => return None,
            Self::Mesh { mesh } => {
                let solid = meshes.get(*mesh)?.solid();
                if solid.mass_kg <= 0.0 {
                    return None;
                }
                let density = mass_kg / solid.mass_kg;
                Inertial {
                    mass_kg,
                    centre_m: solid.centre_m,
                    tensor_kg_m2: solid.tensor_kg_m2.map(|moment| moment * density),
                }
            }
        })
    }
}

/// Moments of a capsule across and along its axis.
fn capsule_moments(mass_kg: f64, r: f64, l: f64) -> (f64, f64) {
    let ball_share = (4.0 / 3.0 * r) / (l + 4.0 / 3.0 * r);
    let (balls, cylinder) = (mass_kg * ball_share, mass_kg * (1.0 - ball_share));
    let out = l / 2.0 + 3.0 / 8.0 * r;
    let across =
        cylinder / 12.0 * (3.0 * r * r + l * l) + balls * (83.0 / 320.0 * r * r + out * out);
    (across, cylinder / 2.0 * r * r + balls * 2.0 / 5.0 * r * r)
}
