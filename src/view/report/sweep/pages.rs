use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use crate::io::{Existing, Folder, SMALL_PAGE, refuse_link};
use crate::sweep::{Results, Sweep, SweepFolder};
use crate::view::ViewError;
use crate::view::report::{small_page, write};

/// Path of the page in the folder of a run.
#[must_use]
pub fn run_page_in(run: &Path) -> PathBuf {
    run.join(SMALL_PAGE)
}

/// Makes a small page for each run with results, unless the existing page is newer than the run. Returns all errors.
pub fn write_run_pages(folder: &SweepFolder, sweep: &Sweep, results: &Results) -> Vec<ViewError> {
    let with = sweep.points().iter().zip(&results.points).filter(|(_, result)| !result.measurements.is_empty());
    with.filter_map(|(point, _)| write_page(&folder.of(point)).err()).collect()
}

fn write_page(run: &Path) -> Result<(), ViewError> {
    let path = run_page_in(run);
    refuse_link(&path).map_err(|error| ViewError::Write { path: path.clone(), source: io::Error::other(error) })?;
    let changed = |path: &Path| fs::metadata(path).and_then(|file| file.modified()).ok();
    let page = changed(&path);
    let is_new = page.is_some() && Folder::files_of(run).iter().all(|file| changed(file) <= page);
    if is_new { Ok(()) } else { write(&small_page(run)?, &path, Existing::Replace) }
}
