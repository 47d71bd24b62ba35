use super::html::{escape, number, numbers, table};
use crate::analysis::observables::{Answer, Equilibrium};
use crate::io::Summary;
use crate::model::Scene;
use crate::view::audit::{self, Row};

pub(super) fn section(summary: &Summary, scene: Option<&Scene>) -> String {
    let verdict = if summary.faults.is_empty() {
        "<p class=\"sound\"><strong>✓ Sound.</strong> All conserved quantities were constant within round-off, \
         and no particles overlapped more deeply than round-off explains or the scene allows.</p>\n"
            .to_owned()
    } else {
        let faults: String = summary.faults.iter().map(|fault| format!("<li>{}</li>\n", escape(fault))).collect();
        format!(
            "<p class=\"failed\"><strong>✗ Failed.</strong> These results cannot be trusted:</p>\n<ul>\n{faults}</ul>\n"
        )
    };
    let state = state(&summary.equilibrated);
    let rows: String = audit::rows(summary, scene).iter().map(line).collect();
    let heads = [("", "what"), ("n", "value"), ("n", "limit"), ("", "verdict")];
    let table = table("audit", "Audit of the whole run, including its equilibration", heads, &rows);
    format!("{verdict}{state}<details>\n<summary>The audit in numbers</summary>\n{table}</details>\n")
}

/// Describes the test of equilibrium, which is not a part of the audit.
fn state(equilibrium: &Equilibrium) -> String {
    let reasons: Vec<String> = equilibrium.reasons.iter().map(|reason| escape(&number(reason))).collect();
    let reasons = reasons.join(", ");
    match equilibrium.verdict {
        Answer::Yes => {
            "<p class=\"sound\"><strong>✓ Equilibrated: yes.</strong> No observable drifts while it is measured.</p>\n"
                .to_owned()
        }
        Answer::No if equilibrium.reasons.iter().any(|reason| reason == Equilibrium::COOLS) => format!(
            "<p class=\"failed\"><strong>✗ Equilibrated: no.</strong> Between the first quarter and the second half of the \
             measurement {reasons}. The means are averages over the time of the measurement.</p>\n"
        ),
        Answer::No => format!(
            "<p class=\"failed\"><strong>✗ Equilibrated: no.</strong> Between the first quarter and the second half of the \
             measurement {reasons}: means and errors do not describe a steady state. Use a longer equilibration or a \
             longer run.</p>\n"
        ),
        Answer::Unknown => {
            let reasons = if reasons.is_empty() { "this run does not tell".to_owned() } else { reasons };
            format!("<p><strong>Equilibrated: unknown</strong> ({reasons}).</p>\n")
        }
    }
}

fn line(row: &Row) -> String {
    let verdict = match row.is_sound {
        Some(true) => "<td class=\"sound\">✓ within</td>",
        Some(false) => "<td class=\"failed\">✗ beyond</td>",
        None => "<td></td>",
    };
    format!(
        "<tr><th scope=\"row\">{}<small>{}</small></th><td class=\"n\">{}</td><td class=\"n limit\">{}</td>{verdict}</tr>\n",
        row.what,
        row.why.as_ref().map_or_else(|| row.how.to_owned(), |why| format!("changed by {}", escape(why))),
        escape(&numbers(&row.value)),
        escape(&number(&row.limit)),
    )
}
