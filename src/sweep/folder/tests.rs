use super::*;
use std::sync::Barrier;
use std::thread;

const FLUID: &str = "configs/hard_sphere_fluid.toml";

fn sweep(set: &[(&str, &str)], axes: &[&str]) -> Sweep {
    Sweep::new(FLUID, set, axes.iter().map(|axis| axis.parse().unwrap()).collect()).unwrap()
}

#[test]
fn folder_belongs_to_one_sweep() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("sweep");
    let first = sweep(&[("run.until_events", "10")], &["seed=1..3", "fill.0.packing_fraction=0.1,0.2"]);
    SweepFolder::open(&path, &first).unwrap();
    let again = Sweep::from_file(SweepFolder::file_in(&path)).unwrap();
    assert_eq!((again.points(), again.set()), (first.points(), first.set()));
    SweepFolder::open(&path, &again).unwrap();
    let more = sweep(&[("run.until_events", "10")], &["seed=1..9", "fill.0.packing_fraction=0.1,0.2"]);
    SweepFolder::open(&path, &more).unwrap();
    assert_eq!(Sweep::from_file(SweepFolder::file_in(&path)).unwrap().points().len(), 18);
    let refused = |other: &Sweep| SweepFolder::open(&path, other).unwrap_err();
    let keys = sweep(&[("run.until_events", "10")], &["seed=1..3"]);
    assert!(matches!(refused(&keys), SweepError::Other { why, .. } if why.contains("packing_fraction")));
    let set = sweep(&[], &["seed=1..3", "fill.0.packing_fraction=0.1,0.2"]);
    assert!(matches!(refused(&set), SweepError::Other { why, .. } if why.contains("until_events=10, not nothing")));
    let changed = directory.path().join("changed.toml");
    fs::write(&changed, fs::read_to_string(FLUID).unwrap() + "\n").unwrap();
    let axes = ["seed=1..3", "fill.0.packing_fraction=0.1,0.2"].map(|axis| axis.parse().unwrap());
    let changed = Sweep::new(&changed, &[("run.until_events", "10")], axes.into()).unwrap();
    assert!(matches!(refused(&changed), SweepError::Changed { .. }));
}

#[test]
fn a_folder_with_something_else_is_not_touched() {
    let directory = tempfile::tempdir().unwrap();
    fs::write(directory.path().join("thesis.tex"), "").unwrap();
    let error = SweepFolder::open(directory.path(), &sweep(&[], &["seed=1,2"])).unwrap_err();
    assert!(matches!(error, SweepError::Occupied(_)));
    assert_eq!(fs::read_dir(directory.path()).unwrap().count(), 1);
}

#[test]
fn scene_given_as_text_is_stored_in_the_sweep_folder() {
    let directory = tempfile::tempdir().unwrap();
    let text = fs::read_to_string(FLUID).unwrap();
    let path = directory.path().join("sweep");
    let axes = || vec!["seed=1,2".parse().unwrap()];
    let sweep = Sweep::of_text(text.as_str(), "fluid.toml", &[("run.until_events", "10")], axes()).unwrap();
    SweepFolder::open(&path, &sweep).unwrap();
    let again = Sweep::from_file(SweepFolder::file_in(&path)).unwrap();
    assert_eq!((again.points(), again.set()), (sweep.points(), sweep.set()));
    SweepFolder::open(&path, &again).unwrap();
    assert!(fs::read_to_string(path.join(SWEEP)).unwrap().contains("scene = \"scene.toml\""));
    // The folder accepts its own scene, and rejects a scene with a changed text.
    SweepFolder::open(&path, &sweep).unwrap();
    assert_eq!(fs::read_to_string(path.join(SCENE)).unwrap(), text);
    let other = Sweep::of_text(text + "\n", "fluid.toml", &[("run.until_events", "10")], axes()).unwrap();
    assert!(matches!(SweepFolder::open(&path, &other), Err(SweepError::Changed { .. })));
}

#[test]
fn sweep_file_paths_are_relative_to_its_folder() {
    let directory = tempfile::tempdir().unwrap();
    fs::copy(FLUID, directory.path().join("fluid.toml")).unwrap();
    let file = directory.path().join("study.toml");
    fs::write(&file, "scene = \"fluid.toml\"\nvary = [\"seed=1..3\"]\nset = [\"run.until_events=10\"]\n").unwrap();
    let sweep = Sweep::from_file(&file).unwrap();
    assert_eq!(sweep.scene_at(&sweep.points()[2]).unwrap().run().limit.events, Some(10));
    fs::write(&file, "scene = \"fluid.toml\"\nvery = [\"seed=1..3\"]\n").unwrap();
    assert!(matches!(Sweep::from_file(&file), Err(SweepError::File { .. })));
}

#[test]
fn failures_are_recorded_and_cleared() {
    let directory = tempfile::tempdir().unwrap();
    let sweep = sweep(&[], &["seed=1,2"]);
    let folder = SweepFolder::open(directory.path().join("sweep"), &sweep).unwrap();
    let [one, two] = sweep.points() else { panic!() };
    folder.keep_failure(one, Some("it jams")).unwrap();
    assert_eq!((folder.failure(one), folder.failure(two)), (Some("it jams".to_owned()), None));
    folder.keep_failure(one, None).unwrap();
    folder.keep_failure(two, None).unwrap();
    assert_eq!(folder.failure(one), None);
    assert!(!folder.path().join(FAILURES).exists());
}

#[test]
fn only_one_of_concurrent_sweeps_gets_the_folder() {
    const SWEEPS: usize = 8;
    let sweeps: Vec<Sweep> =
        (0..SWEEPS).map(|k| sweep(&[("run.until_events", &format!("{}", 10 + k))], &["seed=1..3"])).collect();
    for _ in 0..20 {
        let directory = tempfile::tempdir().unwrap();
        let (path, barrier) = (directory.path().join("sweep"), Barrier::new(SWEEPS));
        let open = |sweep| {
            barrier.wait();
            SweepFolder::open(&path, sweep)
        };
        let results: Vec<_> = thread::scope(|scope| {
            let threads: Vec<_> = sweeps.iter().map(|sweep| scope.spawn(move || open(sweep))).collect();
            threads.into_iter().map(|thread| thread.join().unwrap()).collect()
        });
        let has = results.iter().position(Result::is_ok).unwrap();
        assert_eq!(results.iter().filter(|result| result.is_ok()).count(), 1, "{results:?}");
        let others = results.iter().filter_map(|result| result.as_ref().err());
        let says = format!("it sets run.until_events={}", 10 + has);
        for error in others {
            assert!(matches!(error, SweepError::Other { why, .. } if why.contains(&says)), "{error:?}");
        }
    }
}
