use std::fmt::{Display, Write};
use std::path::Path;
use std::time::Duration;

/// Default wall time between two checkpoints, in seconds.
pub const CHECKPOINT_EVERY: &str = "300";

/// A shell command that resumes interrupted work, with the options that the folder does not store.
#[derive(Debug, Clone)]
pub struct Again(String);

impl Again {
    pub fn new(words: &str, folder: &Path) -> Self {
        Self(format!("carom {words} {}", quoted(&folder.to_string_lossy())))
    }

    pub fn option(mut self, name: &str, value: Option<impl Display>) -> Self {
        if let Some(value) = value {
            // Writing to a string cannot fail.
            let _ = write!(self.0, " --{name} {value}");
        }
        self
    }

    pub fn checkpoint_every(self, interval: Duration) -> Self {
        let seconds = interval.as_secs_f64().to_string();
        self.option("checkpoint-every", (seconds != CHECKPOINT_EVERY).then_some(seconds))
    }

    pub fn flags(mut self, flags: [(&str, bool); 2]) -> Self {
        for (name, _) in flags.into_iter().filter(|(_, is_given)| *is_given) {
            let _ = write!(self.0, " --{name}");
        }
        self
    }
}

impl Display for Again {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

fn quoted(word: &str) -> String {
    let is_plain = |c: char| c.is_alphanumeric() || matches!(c, '/' | '.' | '_' | '-' | '+' | ':' | '@' | '%' | ',');
    if !word.is_empty() && word.chars().all(is_plain) {
        return word.to_owned();
    }
    format!("'{}'", word.replace('\'', "'\\''"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn repeated_command_has_exactly_the_given_options() {
        let again = |folder: &str| Again::new("run --resume", Path::new(folder));
        let usual = Duration::from_secs_f64(CHECKPOINT_EVERY.parse().unwrap());
        let plain = again("runs/a").option("threads", None::<u8>).checkpoint_every(usual);
        assert_eq!(plain.flags([("force", false), ("quiet", false)]).to_string(), "carom run --resume runs/a");
        let all = again("my runs/it's").option("threads", Some(4)).checkpoint_every(Duration::from_millis(1500));
        assert_eq!(
            all.flags([("force", true), ("quiet", true)]).to_string(),
            "carom run --resume 'my runs/it'\\''s' --threads 4 --checkpoint-every 1.5 --force --quiet"
        );
    }
}
