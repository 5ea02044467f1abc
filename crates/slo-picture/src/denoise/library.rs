//! The C interface of Open Image Denoise 2, loaded while the program runs.
//!
//! Calling a shared library needs `unsafe`. All of it stays in this file, behind functions that check
//! what the library relies on.

use std::error::Error;
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::path::{Path, PathBuf};
use std::ptr;

use libloading::Library;

use crate::film::Image;

/// File names of the library.
pub(super) const NAMES: &[&str] = if cfg!(target_os = "windows") {
    &["OpenImageDenoise.dll"]
} else if cfg!(target_os = "macos") {
    &["libOpenImageDenoise.2.dylib", "libOpenImageDenoise.dylib"]
} else {
    &["libOpenImageDenoise.so.2", "libOpenImageDenoise.so"]
};

/// `OIDN_DEVICE_TYPE_CPU`: the device that every machine has, and that shares our memory.
const CPU: c_int = 1;
/// `OIDN_FORMAT_FLOAT3`
const FLOAT3: c_int = 3;

type Handle = *mut c_void;

/// The functions of the library, as `oidn.h` of version 2 declares them.
#[derive(Clone, Copy, Debug)]
struct Functions {
    new_device: unsafe extern "C" fn(c_int) -> Handle,
    set_device_int: unsafe extern "C" fn(Handle, *const c_char, c_int),
    get_device_int: unsafe extern "C" fn(Handle, *const c_char) -> c_int,
    commit_device: unsafe extern "C" fn(Handle),
    release_device: unsafe extern "C" fn(Handle),
    get_device_error: unsafe extern "C" fn(Handle, *mut *const c_char) -> c_int,
    new_filter: unsafe extern "C" fn(Handle, *const c_char) -> Handle,
    set_image: SetImage,
    set_filter_bool: unsafe extern "C" fn(Handle, *const c_char, bool),
    commit_filter: unsafe extern "C" fn(Handle),
    execute_filter: unsafe extern "C" fn(Handle),
    release_filter: unsafe extern "C" fn(Handle),
}

/// Filter, name, pixels, format, width, height, offset, bytes per pixel, bytes per row; 0: dense.
type SetImage = unsafe extern "C" fn(
    Handle,
    *const c_char,
    *mut c_void,
    c_int,
    usize,
    usize,
    usize,
    usize,
    usize,
);

impl Functions {
    /// # Safety
    /// The library is Open Image Denoise 2.
    unsafe fn of(library: &Library) -> Result<Self, libloading::Error> {
        // SAFETY: the types are those of the library's header, and the pointers go no further than
        // `Device`, which keeps the library.
        unsafe {
            Ok(Self {
                new_device: *library.get(c"oidnNewDevice")?,
                set_device_int: *library.get(c"oidnSetDeviceInt")?,
                get_device_int: *library.get(c"oidnGetDeviceInt")?,
                commit_device: *library.get(c"oidnCommitDevice")?,
                release_device: *library.get(c"oidnReleaseDevice")?,
                get_device_error: *library.get(c"oidnGetDeviceError")?,
                new_filter: *library.get(c"oidnNewFilter")?,
                set_image: *library.get(c"oidnSetSharedFilterImage")?,
                set_filter_bool: *library.get(c"oidnSetFilterBool")?,
                commit_filter: *library.get(c"oidnCommitFilter")?,
                execute_filter: *library.get(c"oidnExecuteFilter")?,
                release_filter: *library.get(c"oidnReleaseFilter")?,
            })
        }
    }
}

/// A device of the library: the processor.
#[derive(Debug)]
pub(super) struct Device {
    functions: Functions,
    handle: Handle,
    /// The functions point into it.
    _library: Library,
}

impl Device {
    /// Loads the library at `path`, or the first that the system finds, with so many threads; `None`: all.
    pub(super) fn load(path: Option<&Path>, threads: Option<u32>) -> Result<Self, String> {
        let library = open(path)?;
        // SAFETY: the library was named as Open Image Denoise; version 1 lacks some of the names.
        let functions = unsafe { Functions::of(&library) }
            .map_err(|error| format!("the library is not Open Image Denoise 2: {error}"))?;
        // SAFETY: no device is needed to ask for one.
        let handle = unsafe { (functions.new_device)(CPU) };
        let device = Self { functions, handle, _library: library };
        if handle.is_null() {
            return Err(device.error().unwrap_or_else(|| "there is no processor for it".into()));
        }
        // SAFETY: the handle is that of a device, and the name ends with a zero.
        unsafe {
            if let Some(threads) = threads {
                let threads = c_int::try_from(threads).unwrap_or(c_int::MAX);
                (functions.set_device_int)(handle, c"numThreads".as_ptr(), threads);
            }
            (functions.commit_device)(handle);
        }
        device.error().map_or(Ok(device), Err)
    }

    /// Major, minor, patch.
    pub(super) fn version(&self) -> [i32; 3] {
        // SAFETY: the handle is that of a device, and the name ends with a zero.
        let version = unsafe { (self.functions.get_device_int)(self.handle, c"version".as_ptr()) };
        [version / 10_000, version / 100 % 100, version % 100]
    }

    /// Runs the filter for ray tracing on named images, with some flags set.
    ///
    /// # Errors
    /// What the library says; images of several sizes.
    pub(super) fn filter(
        &self,
        images: &[(&str, &Image)],
        flags: &[&str],
    ) -> Result<Image, String> {
        let Some(&(_, Image { width, height, .. })) = images.first() else {
            return Err("there is no picture".into());
        };
        let pixels = *width as usize * *height as usize;
        if images.iter().any(|(_, i)| (i.width, i.rgb.len()) != (*width, pixels)) {
            return Err("its layers and the picture differ in size".into());
        }
        let mut result = Image { width: *width, height: *height, rgb: vec![[0.0; 3]; pixels] };
        let filter = Filter::new(self)?;
        for (name, image) in images {
            let name = CString::new(*name).map_err(|error| error.to_string())?;
            // SAFETY: what is not called `output` is only read.
            unsafe { filter.set(&name, image.rgb.as_ptr().cast_mut(), image) };
        }
        let place = result.rgb.as_mut_ptr();
        // SAFETY: `result` is borrowed by nobody else until the filter is gone.
        unsafe { filter.set(c"output", place, &result) };
        for flag in flags {
            let flag = CString::new(*flag).map_err(|error| error.to_string())?;
            // SAFETY: the handle is that of a filter, and the name ends with a zero.
            unsafe { (self.functions.set_filter_bool)(filter.handle, flag.as_ptr(), true) };
        }
        filter.execute();
        drop(filter);
        self.error().map_or(Ok(result), Err)
    }

    /// The error since the last call, if there was one.
    fn error(&self) -> Option<String> {
        let mut message = ptr::null();
        // SAFETY: null stands for errors of making a device; the message is the library's, valid
        // until the next call, and ends with a zero.
        let text = unsafe {
            let code = (self.functions.get_device_error)(self.handle, &raw mut message);
            if code == 0 {
                return None;
            }
            if message.is_null() { c"" } else { CStr::from_ptr(message) }
        };
        Some(text.to_string_lossy().into_owned())
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        if !self.handle.is_null() {
            // SAFETY: the handle is that of a device, and no filter is left: filters borrow it.
            unsafe { (self.functions.release_device)(self.handle) };
        }
    }
}

struct Filter<'d> {
    device: &'d Device,
    handle: Handle,
}

impl<'d> Filter<'d> {
    /// The filter for ray tracing.
    fn new(device: &'d Device) -> Result<Self, String> {
        // SAFETY: the handle is that of a device, and the name ends with a zero.
        let handle = unsafe { (device.functions.new_filter)(device.handle, c"RT".as_ptr()) };
        if handle.is_null() {
            return Err(device.error().unwrap_or_else(|| "it has no filter".into()));
        }
        Ok(Self { device, handle })
    }

    /// # Safety
    /// `pixels` has as many pixels as `size`, for as long as the filter lives, and may be written to
    /// if the name is `output`.
    unsafe fn set(&self, name: &CStr, pixels: *mut [f32; 3], size: &Image) {
        let (width, height) = (size.width as usize, size.height as usize);
        let set = self.device.functions.set_image;
        // SAFETY: three floats a pixel, one pixel and one row after the other, as FLOAT3 has them.
        unsafe { set(self.handle, name.as_ptr(), pixels.cast(), FLOAT3, width, height, 0, 0, 0) };
    }

    fn execute(&self) {
        // SAFETY: the handle is that of a filter; the images were set to memory that is there.
        unsafe {
            (self.device.functions.commit_filter)(self.handle);
            (self.device.functions.execute_filter)(self.handle);
        }
    }
}

impl Drop for Filter<'_> {
    fn drop(&mut self) {
        // SAFETY: the handle is that of a filter, which nobody uses any more.
        unsafe { (self.device.functions.release_filter)(self.handle) };
    }
}

fn open(path: Option<&Path>) -> Result<Library, String> {
    // A second C library would be loaded with it, which may be another version: that can crash.
    if cfg!(target_feature = "crt-static") {
        return Err("this slo-rt is linked statically, so it can't load libraries; use the \
                    program of the release that is not static"
            .into());
    }
    let names: Vec<&Path> =
        path.map_or_else(|| NAMES.iter().map(Path::new).collect(), |path| vec![path]);
    let mut why = Vec::new();
    for name in names {
        // SAFETY: loading runs the library's own initialisation, which is what the user asked for.
        match unsafe { Library::new(as_path(name)) } {
            Ok(library) => return Ok(library),
            Err(error) => why.push(refusal(name, &error)),
        }
    }
    Err(why.join("; "))
}

/// The system's loader does not search the current folder for a name without a folder, so a file that
/// exists there is passed as a path.
fn as_path(name: &Path) -> PathBuf {
    if name.is_file() { Path::new(".").join(name) } else { name.to_owned() }
}

/// What was tried, and the message of the system's loader, which is in the error's source.
fn refusal(name: &Path, error: &libloading::Error) -> String {
    let mut why = format!("`{}`: {error}", name.display());
    let mut source = error.source();
    while let Some(error) = source {
        why += &format!(": {error}");
        source = error.source();
    }
    why
}
