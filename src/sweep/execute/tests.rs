use std::fs;

use super::*;

#[test]
fn a_conversion_that_failed_is_made_by_the_next_call() {
    let directory = tempfile::tempdir().unwrap();
    let set = [("run.until_events", "100"), ("run.equilibration_events", "1"), ("output.formats", "[\"csv\"]")];
    let sweep = Sweep::new("configs/hard_sphere_fluid.toml", &set, vec!["seed=1".parse().unwrap()]).unwrap();
    let folder = SweepFolder::open(directory.path().join("sweep"), &sweep).unwrap();
    let point = &sweep.points()[0];
    let converted = folder.of(point).join("trajectory.csv");
    let execute = |report: &(dyn Fn(&Finished) -> String + Sync)| {
        let orders = Orders {
            jobs: 1,
            share: Share::ALL,
            checkpoint_every: Duration::from_secs(300),
            most_bytes: f64::INFINITY,
            report,
            instruments: &|run| run,
            instrument_names: &[],
        };
        folder.execute_point(&sweep, point, &orders, &mut |_| ControlFlow::Continue(())).unwrap()
    };
    // A folder blocks the name of the converted file, so only the conversion fails.
    let blocks = |_: &Finished| {
        fs::create_dir(&converted).unwrap();
        fs::write(converted.join("mine"), "").unwrap();
        String::new()
    };
    let first = execute(&blocks);
    assert!(matches!(&first, Fate::Failed(why) if why.contains("trajectory.csv")), "{first:?}");
    let once_more = |_: &Finished| -> String { panic!("the run was there already") };
    assert!(matches!(execute(&once_more), Fate::Failed(_)));
    fs::remove_dir_all(&converted).unwrap();
    // Deletes the record of the failure, as if the disk had been full.
    folder.keep_failure(point, None).unwrap();
    assert_eq!(execute(&once_more), Fate::Done);
    assert!(fs::read_to_string(&converted).unwrap().lines().count() > 1);
    assert_eq!((execute(&once_more), folder.failure(point)), (Fate::Kept, None));
    fs::remove_file(&converted).unwrap();
    fs::create_dir(&converted).unwrap();
    fs::write(converted.join("mine"), "").unwrap();
    let last = execute(&once_more);
    assert!(matches!(&last, Fate::Failed(why) if why.contains("trajectory.csv")), "{last:?}");
    assert!(converted.join("mine").exists());
}
