//! The table of MuJoCo functions this crate calls, resolved when the library is loaded.
//!
//! Everything here is `unsafe` by nature; [`super::Engine`] and [`super::Simulation`] are the safe
//! faces. Signatures follow `mujoco.h` of version 3.17.0.

use std::ffi::{c_char, c_int, c_void};
use std::path::Path;

use libloading::Library;

/// Object kinds of `mjtObj`, as `mj_name2id` takes them.
#[derive(Debug, Clone, Copy)]
pub(super) enum ObjectKind {
    Body = 1,
    Joint = 3,
    Geom = 5,
}

/// Opaque `mjModel`.
#[repr(C)]
pub(super) struct RawModel {
    _private: [u8; 0],
}

/// Opaque `mjData`; fields are reached through [`super::layout`].
#[repr(C)]
pub(super) struct RawData {
    _private: [u8; 0],
}

/// Opaque `mjSpec`.
#[repr(C)]
pub(super) struct RawSpec {
    _private: [u8; 0],
}

/// Declares the table: one field per function, filled by name.
macro_rules! function_table {
    ($($field:ident = $symbol:literal : fn($($argument:ty),*) $(-> $result:ty)?;)*) => {
        /// MuJoCo's functions, by role; the library stays loaded as long as the table lives.
        pub(super) struct Functions {
            $(pub(super) $field: unsafe extern "C" fn($($argument),*) $(-> $result)?,)*
            _library: Library,
        }

        impl Functions {
            /// Resolves every function of the table in an opened library.
            ///
            /// # Safety
            /// `library` must be MuJoCo 3.17.x: the signatures above are taken on trust.
            unsafe fn resolve(library: Library) -> Result<Self, libloading::Error> {
                $(
                    // SAFETY: the caller vouches that the symbol has the declared signature.
                    let $field = *unsafe {
                        library.get::<unsafe extern "C" fn($($argument),*) $(-> $result)?>($symbol)
                    }?;
                )*
                Ok(Self { $($field,)* _library: library })
            }
        }
    };
}

function_table! {
    parse_xml_string = b"mj_parseXMLString":
        fn(*const c_char, *const c_void, *mut c_char, c_int) -> *mut RawSpec;
    compile = b"mj_compile": fn(*mut RawSpec, *const c_void) -> *mut RawModel;
    spec_error = b"mjs_getError": fn(*mut RawSpec) -> *const c_char;
    delete_spec = b"mj_deleteSpec": fn(*mut RawSpec);
    delete_model = b"mj_deleteModel": fn(*mut RawModel);
    make_data = b"mj_makeData": fn(*const RawModel) -> *mut RawData;
    copy_data = b"mj_copyData":
        fn(*mut RawData, *const RawModel, *const RawData) -> *mut RawData;
    delete_data = b"mj_deleteData": fn(*mut RawData);
    step = b"mj_step": fn(*const RawModel, *mut RawData);
    step1 = b"mj_step1": fn(*const RawModel, *mut RawData);
    step2 = b"mj_step2": fn(*const RawModel, *mut RawData);
    forward = b"mj_forward": fn(*const RawModel, *mut RawData);
    name_to_id = b"mj_name2id": fn(*const RawModel, c_int, *const c_char) -> c_int;
    state_size = b"mj_stateSize": fn(*const RawModel, c_int) -> c_int;
    get_state = b"mj_getState": fn(*const RawModel, *const RawData, *mut f64, c_int);
    set_state = b"mj_setState": fn(*const RawModel, *mut RawData, *const f64, c_int);
    contact_force = b"mj_contactForce": fn(*const RawModel, *const RawData, c_int, *mut f64);
    object_velocity = b"mj_objectVelocity":
        fn(*const RawModel, *const RawData, c_int, c_int, *mut f64, c_int);
    ray = b"mj_ray":
        fn(*const RawModel, *const RawData, *const f64, *const f64, *const u8, bool, c_int,
           *mut c_int, *mut f64) -> f64;
    geom_distance = b"mj_geomDistance":
        fn(*const RawModel, *mut RawData, c_int, c_int, f64, *mut f64) -> f64;
}

/// Why the library could not be opened, before any of its functions was trusted.
pub(super) enum OpenError {
    /// The file could not be loaded or lacks a function.
    Load(libloading::Error),
    /// `mj_version()` gave this number instead of one of the accepted.
    Version(c_int),
}

/// Opens the library, checks its version and only then resolves the table.
///
/// # Safety
/// Loading runs the library's initialisers: `path` must name a library the caller trusts.
pub(super) unsafe fn open(
    path: &Path,
    accepted: std::ops::Range<c_int>,
) -> Result<(Functions, c_int), OpenError> {
    // SAFETY: the caller trusts the file; MuJoCo's initialisers only fill tables.
    let library = unsafe { Library::new(path) }.map_err(OpenError::Load)?;
    let version = {
        // SAFETY: `int mj_version(void)` in every MuJoCo release.
        let function = unsafe { library.get::<unsafe extern "C" fn() -> c_int>(b"mj_version") }
            .map_err(OpenError::Load)?;
        // SAFETY: as above; it takes nothing and returns a constant.
        unsafe { function() }
    };
    if !accepted.contains(&version) {
        return Err(OpenError::Version(version));
    }
    // SAFETY: the version was checked, so the signatures are those of its header.
    let functions = unsafe { Functions::resolve(library) }.map_err(OpenError::Load)?;
    // SAFETY: the hook is a plain global function pointer of the checked version.
    unsafe { functions.silence_warnings() }.map_err(OpenError::Load)?;
    Ok((functions, version))
}

/// A warning handler that does nothing: warnings are counted in the simulation's data, and
/// MuJoCo's default would write a log file into the working directory.
unsafe extern "C" fn ignore_warning(_message: *const c_char) {}

impl Functions {
    /// Replaces MuJoCo's warning hook, once for each time the library is opened.
    ///
    /// # Safety
    /// No other thread may be inside MuJoCo for the first time; storing the same pointer again is
    /// harmless on every supported processor (an aligned word).
    unsafe fn silence_warnings(&self) -> Result<(), libloading::Error> {
        type Hook = Option<unsafe extern "C" fn(*const c_char)>;
        // SAFETY: `mju_user_warning` is a global of exactly this type; only its address is taken.
        let hook = unsafe { self._library.get::<*mut Hook>(b"mju_user_warning") }?;
        // SAFETY: the address is that of a live, aligned, writable pointer-sized global.
        unsafe { (*hook).write_volatile(Some(ignore_warning)) };
        Ok(())
    }
}
