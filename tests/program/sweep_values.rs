//! Sweeps over lists and tables, and the command that continues such a sweep.

use std::process::Stdio;

use super::place::{FLUID, Place, code, errors, line, send_signal, wait_until};

fn cells(line: &str) -> Vec<String> {
    let mut is_quoted = false;
    let is_end = |c: char| {
        is_quoted ^= c == '"';
        c == ',' && !is_quoted
    };
    line.split(is_end).map(str::to_owned).collect()
}

fn column(table: &str, head: &str) -> Vec<String> {
    let mut lines = table.lines().map(cells);
    let Some(at) = lines.next().unwrap().iter().position(|name| name == head) else { return Vec::new() };
    lines.map(|cells| cells[at].clone()).collect()
}

#[test]
fn sweep_over_lists_or_tables_plots_against_the_changed_entry() {
    let place = Place::with(FLUID);
    let bath = |temperature: &str| format!("{{ kind = \"andersen\", temperature = {temperature}, rate = 1.0 }}");
    let vary = format!("run.thermostat={},{}", bath("1.0"), bath("2.0"));
    place.done(&["sweep", "scene.toml", "--vary", &vary, "--out", "s"]);
    for table in ["s/sweep.csv", "s/sweep-mean.csv"] {
        let temperatures = column(&place.read(table), "thermostat_temperature");
        let temperatures: Vec<f64> = temperatures.iter().map(|cell| cell.parse().unwrap()).collect();
        assert_eq!(temperatures, [1.0, 2.0], "{table}");
        assert!(column(&place.read(table), "thermostat_rate").is_empty());
    }
    for folder in column(&place.read("s/sweep.csv"), "folder") {
        assert!(folder.starts_with("thermostat-andersenx1x") && folder.len() < 40, "{folder}");
    }
    assert!(place.read("s/sweep-columns.csv").contains("thermostat_temperature,,an entry of the key run.thermostat"));
    let page = place.read("s/sweep.html");
    assert!(page.contains("thermostat temperature") && page.contains("<svg"));
}

#[cfg(unix)]
#[test]
fn interrupted_sweep_prints_a_command_with_all_options() {
    let place = Place::with(FLUID);
    let options = ["--jobs", "1", "--array", "1/2", "--checkpoint-every", "0.5", "--force"];
    let sweep = ["sweep", "scene.toml", "--vary", "seed=1,2", "--set", "run.until_events=100000000", "--out", "my s"];
    let mut command = place.command(&[&sweep[..], &options].concat());
    let mut child = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    let checkpoint = place.path().join("my s/seed-1/checkpoint");
    wait_until(|| checkpoint.exists() || child.try_wait().unwrap().is_some());
    send_signal(&child, "-INT");
    let output = child.wait_with_output().unwrap();
    let again = "carom sweep 'my s' --jobs 1 --array 1/2 --checkpoint-every 0.5 --force";
    assert_eq!(code(&output), 1, "{}", errors(&output));
    assert!(line(&output).contains(again), "{}", line(&output));
}
