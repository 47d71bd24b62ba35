use super::*;
use crate::sweep::entries::Entry;

const SCENE: &str = "configs/hard_sphere_fluid.toml";

fn sweep(axes: &[&str]) -> Result<Sweep, SweepError> {
    Sweep::new(SCENE, &[], axes.iter().map(|axis| axis.parse().unwrap()).collect())
}

#[test]
fn points_are_all_combinations_with_the_last_axis_fastest() {
    let sweep = sweep(&["fill.0.packing_fraction=0.1,0.2; run.until_events=100,200", "seed=1..3"]).unwrap();
    let folders: Vec<&str> = sweep.points().iter().map(Point::folder).collect();
    assert_eq!(folders.len(), 6);
    assert_eq!(folders[1], "packing_fraction-0.1_until_events-100_seed-2");
    assert_eq!(folders[3], "packing_fraction-0.2_until_events-200_seed-1");
    let state: Vec<&str> = sweep.points()[3].state_point().map(|(_, value)| value.as_str()).collect();
    assert_eq!(state, ["0.2", "200"]);
    let scene = sweep.scene_at(&sweep.points()[4]).unwrap();
    assert_eq!((scene.seed(), scene.run().limit.events), (2, Some(200)));
    assert!((scene.packing_fraction() - 0.2).abs() < 1e-9);
}

#[test]
fn short_names_are_used_if_unambiguous() {
    let names = |axes: &[&str]| sweep(axes).unwrap().short_names();
    assert_eq!(names(&["fill.0.count=1,2", "species.A.mass=1,2"]), ["count", "mass"]);
    assert_eq!(names(&["species.A.mass=1,2", "species.B.mass=1,2"]), ["species_A_mass", "species_B_mass"]);
    assert_eq!(names(&["space.size=[1,1,1],[2,2,2]", "dynamics.gravity.1=1,2"]), ["size", "gravity_1"]);
    assert_eq!(names(&["surface.a.profile.0.1=1,2", "surface.a.profile.1=[1],[2]"]), ["profile_0_1", "profile_1"]);
    assert_eq!(names(&["run.thermostat.temperature=1,2"]), ["thermostat_temperature"]);
    assert_eq!(names(&["fill.0.temperature=1,2", "seed=1,2"]), ["fill_0_temperature", "seed"]);
    assert_eq!(names(&["run.barostat.pressure=1,2", "run.barostat.interval=1,2"]), ["barostat_pressure", "interval"]);
    // With a barostat, the packing fraction is also measured.
    let fractions = ["fill.0.packing_fraction=0.1,0.2", "run.barostat.interval=1,2"];
    assert_eq!(names(&fractions), ["fill_0_packing_fraction", "interval"]);
    assert_eq!(names(&fractions[..1]), ["packing_fraction"]);
    assert_eq!(names(&["a.x.0=1,2", "b.x.0=1,2", "c.0=1,2"]), ["a_x_0", "b_x_0", "c_0"]);
}

#[test]
fn a_density_beside_a_barostat_is_named_by_its_whole_key() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("scene.toml");
    let text = std::fs::read_to_string(SCENE).unwrap();
    let bath = "thermostat = { kind = \"andersen\", temperature = 1.0, rate = 1.0 }";
    let names = |line: &str, set: &[(&str, &str)]| {
        std::fs::write(&file, text.replace("[run]", &format!("[run]\n{bath}\n{line}"))).unwrap();
        Sweep::new(&file, set, vec!["fill.0.packing_fraction=0.1,0.2".parse().unwrap()]).unwrap().short_names()
    };
    let barostat = "{ pressure = 1.0, interval = 1.0, amplitude = 0.1 }";
    assert_eq!(names(&format!("barostat = {barostat}"), &[]), ["fill_0_packing_fraction"]);
    assert_eq!(names("", &[("run.barostat", barostat)]), ["fill_0_packing_fraction"]);
    assert_eq!(names("# A word of a barostat is none.", &[]), ["packing_fraction"]);
}

#[test]
fn folders_have_names_that_every_disk_takes() {
    let sweep = sweep(&["space.size=[1, 1, 1],[1; 1; 1],\"a/../b\""]).unwrap();
    for point in sweep.points() {
        assert!(!point.folder().contains(['/', ' ', '[', ';', '"']) && point.folder().len() < 150, "{point:?}");
    }
    let names: BTreeSet<&str> = sweep.points().iter().map(Point::folder).collect();
    assert_eq!(names.len(), 3);
    let words = super::Sweep::new(SCENE, &[], vec!["fill.0.arrangement=fcc,FCC".parse().unwrap()]).unwrap();
    let names: BTreeSet<String> = words.points().iter().map(|point| point.folder().to_lowercase()).collect();
    assert_eq!(names.len(), 2);
}

#[test]
fn ambiguous_sweeps_are_rejected() {
    assert!(matches!(sweep(&[]), Err(SweepError::NoAxis)));
    assert!(matches!(sweep(&["seed=1,2", "seed=3,4"]), Err(SweepError::Twice(key)) if key == "seed"));
    for values in ["seed=1,1", "seed=1,+1,0x1", "fill.0.packing_fraction=0.1,1e-1", "fill.0.arrangement=fcc,\"fcc\""] {
        assert!(matches!(sweep(&[values]), Err(SweepError::SameValue { .. })), "{values}");
    }
    for axes in [
        ["species.0.mass=1,2", "species.sphere.mass=1,2"],
        ["species.0.mass=1,2", "species.0={},{a=1}"],
        ["fill.0.count=1,2; fill. 0 .count=1,2", "seed=1,2"],
    ] {
        assert!(matches!(sweep(&axes), Err(SweepError::SamePlace { .. })), "{axes:?}");
    }
    let set = Sweep::new(SCENE, &[("species.0.mass", "1")], vec!["species.sphere.mass=1,2".parse().unwrap()]);
    assert!(matches!(set, Err(SweepError::SamePlace { .. })));
    // An axis may vary a number inside a table that is overridden.
    let within = Sweep::new(SCENE, &[("space", "{ size = [9, 9, 9] }")], vec!["space.size.0=8,9".parse().unwrap()]);
    assert_eq!(within.unwrap().points().len(), 2);
    assert!(matches!(sweep(&["a=1..1000", "b=1..1000"]), Err(SweepError::TooMany(1_000_000))));
    let twice = Sweep::new(SCENE, &[("seed", "1")], vec!["seed=1,2".parse().unwrap()]);
    assert!(matches!(twice, Err(SweepError::Twice(_))));
    let missing = Sweep::new("configs/nothing.toml", &[], vec!["seed=1,2".parse().unwrap()]);
    assert!(matches!(missing, Err(SweepError::Scene(_))));
}

#[test]
fn keys_are_checked_without_a_scene() {
    let bad = sweep(&["fill.0.packing_fractoin=0.1,0.2"]).unwrap();
    let error = bad.check_keys_at(&bad.points()[0]).unwrap_err().to_string();
    assert!(error.contains("packing_fractoin"), "{error}");
    let bad = sweep(&["fill.0.packing_fraction=0.1,dense"]).unwrap();
    assert!(bad.check_keys_at(&bad.points()[0]).is_ok());
    assert!(bad.check_keys_at(&bad.points()[1]).is_err());
}

#[test]
fn lists_tables_and_files_have_short_folders() {
    let names = |axes: &[&str]| -> Vec<String> {
        sweep(axes).unwrap().points().iter().map(|point| point.folder().to_owned()).collect()
    };
    assert_eq!(
        names(&["space.size=[12.0, 12.0, 9.5],[1, 1, -1e-3]", "seed=1"]),
        ["size-12x12x9.5_seed-1", "size-1x1x-0.001_seed-1"]
    );
    let alone = names(&["start.from=runs/first/fluid"]);
    assert_eq!(alone[0].len(), "from-fluid-12345678".len(), "{alone:?}");
    let both = names(&["start.from=\"runs/second/fluid\",runs/first/fluid,fluid"]);
    assert!(both[0].starts_with("from-fluid-") && both[0] != both[1], "{both:?}");
    assert_eq!([&both[1], &both[2]], [&alone[0], "from-fluid"]);
    let baths = names(&["run.thermostat={ kind = \"andersen\", temperature = 1.5, rate = 2 }"]);
    assert!(baths[0].starts_with("thermostat-andersenx2x1.5-") && baths[0].len() < 40, "{baths:?}");
    let long = names(&["surface.a.profile=[[0.25, 1.25], [0.5, 2.5], [0.75, 3.75], [1.0, 4.0]]"]);
    assert!(long[0].starts_with("profile-0.25x1.25x0.5x2.5") && long[0].len() < 50, "{long:?}");
}

#[test]
fn numeric_list_entries_can_be_plotted_against() {
    let named = |axes: &[&str]| -> Vec<(String, Vec<f64>)> {
        let sweep = sweep(axes).unwrap();
        let values = |entry: &Entry| sweep.points().iter().filter_map(|point| entry.of(point)).collect();
        sweep.entries().iter().map(|entry| (entry.name().to_owned(), values(entry))).collect()
    };
    let of = |name: &str, values: &[f64]| (name.to_owned(), values.to_vec());
    assert_eq!(
        named(&["dynamics.gravity=[0, 0, -1],[0, 0.5, -2]"]),
        [of("gravity_1", &[0.0, 0.5]), of("gravity_2", &[-1.0, -2.0])]
    );
    assert_eq!(
        named(&["run.thermostat={ temperature = 1, rate = 3 },{ temperature = 2, rate = 3 }"]),
        [of("thermostat_temperature", &[1.0, 2.0])]
    );
    assert_eq!(named(&["surface.a.profile=[[0, 1]],[[0, 2]]"]), [of("profile_0_1", &[1.0, 2.0])]);
    // Plain numbers already have a column. Words, and lists of different lengths, are not variables.
    assert_eq!(
        named(&["fill.0.count=1,2", "space.size=[1, 1],[1]", "fill.0.arrangement=fcc,bcc", "start.from=[a],[b]"]),
        []
    );
}
