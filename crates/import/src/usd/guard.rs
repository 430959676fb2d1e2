//! Every file of a stage passes here on its way to the library that reads it, which trusts counts and sizes in files more than it should.

use super::{crate_file, text};
use openusd::ar::{self, Asset, DefaultResolver, ResolvedPath};
use std::cell::RefCell;
use std::fs::File;
use std::io::{self, Cursor, Read};
use std::rc::Rc;

/// The largest file that is read, bytes, unpacked.
const MOST_BYTES: u64 = 4 << 30;

/// Finds files as the library does, and looks at them before it does.
pub(super) struct Resolver {
    files: DefaultResolver,
    refused: Refused,
}

/// Why files were refused.
#[derive(Clone, Default)]
pub(super) struct Refused(Rc<RefCell<Vec<String>>>);

impl Refused {
    pub(super) fn first(&self) -> Option<String> {
        self.0.borrow().first().cloned()
    }
}

impl Resolver {
    pub(super) fn new() -> (Self, Refused) {
        let refused = Refused::default();
        (Resolver { files: DefaultResolver::new(), refused: refused.clone() }, refused)
    }

    fn refuse(&self, path: &ResolvedPath, why: String) -> io::Error {
        let name = path.to_string_lossy();
        self.refused.0.borrow_mut().push(why.clone());
        io::Error::other(format!("{name}: {why}"))
    }
}

impl ar::Resolver for Resolver {
    fn create_identifier(&self, asset_path: &str, anchor: Option<&ResolvedPath>) -> String {
        self.files.create_identifier(asset_path, anchor)
    }

    fn resolve(&self, asset_path: &str) -> Option<ResolvedPath> {
        self.files.resolve(asset_path)
    }

    fn resolve_for_new_asset(&self, asset_path: &str) -> Option<ResolvedPath> {
        self.files.resolve_for_new_asset(asset_path)
    }

    fn identity(&self) -> String {
        self.files.identity()
    }

    fn open_asset(&self, path: &ResolvedPath) -> io::Result<Box<dyn Asset>> {
        let bytes = read(path).map_err(|error| self.refuse(path, error.to_string()))?;
        check(&bytes, &path.to_string_lossy()).map_err(|why| self.refuse(path, why))?;
        Ok(Box::new(Cursor::new(bytes)))
    }
}

/// All bytes of a file, or of one in a package.
fn read(path: &ResolvedPath) -> io::Result<Vec<u8>> {
    let name = path.to_str().unwrap_or_default();
    let mut bytes = Vec::new();
    match ar::split_package_relative_path_outer(name).filter(|_| ar::is_package_relative_path(name)) {
        Some((package, inner)) => {
            let mut archive = zip::ZipArchive::new(File::open(package)?).map_err(io::Error::other)?;
            let entry = archive.by_name(&inner).map_err(io::Error::other)?;
            entry.take(MOST_BYTES + 1).read_to_end(&mut bytes)?;
        }
        None => {
            File::open(&**path)?.take(MOST_BYTES + 1).read_to_end(&mut bytes)?;
        }
    }
    match bytes.len() as u64 > MOST_BYTES {
        true => Err(io::Error::other("larger than 4 GiB")),
        false => Ok(bytes),
    }
}

/// Refuses what the library would stumble over.
fn check(bytes: &[u8], name: &str) -> Result<(), String> {
    if bytes.starts_with(crate_file::MAGIC) {
        return crate_file::check(bytes).map_err(|why| format!("not a sound usdc file: {why}"));
    }
    if name.to_ascii_lowercase().ends_with(".usdz") {
        return Ok(());
    }
    text::check(bytes)
}
