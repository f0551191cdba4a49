//! Another program, with a time limit.

use std::io::{BufRead, BufReader, Read};
use std::process::{Command, ExitStatus, Stdio};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::time::{Duration, Instant};

/// How often the time limit and the user are looked after.
const LOOK_EVERY: Duration = Duration::from_millis(100);

/// A line of the program's output.
pub(crate) enum Line {
    Out(String),
    Error(String),
}

/// How a program has ended.
#[derive(Debug)]
pub(crate) enum Ended {
    Itself(ExitStatus),
    /// It ran beyond its limit and was killed.
    TimedOut,
    /// The user did not want to wait.
    Stopped,
}

/// Runs a program to its end, to the time limit, or until `stopped`; whatever comes first.
pub(crate) fn run_limited(
    command: &mut Command,
    limit: Duration,
    stopped: impl Fn() -> bool,
    mut on_line: impl FnMut(Line),
) -> std::io::Result<Ended> {
    let start = Instant::now();
    let mut child = command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn()?;
    let (sender, lines) = channel();
    if let Some(out) = child.stdout.take() {
        forward(out, sender.clone(), Line::Out);
    }
    if let Some(error) = child.stderr.take() {
        forward(error, sender, Line::Error);
    }
    loop {
        let end = match lines.recv_timeout(LOOK_EVERY) {
            Ok(line) => {
                on_line(line);
                None
            }
            // Both outputs are closed, and the program may still go on.
            Err(RecvTimeoutError::Disconnected) => {
                std::thread::sleep(Duration::from_millis(1));
                child.try_wait()?.map(Ended::Itself)
            }
            Err(RecvTimeoutError::Timeout) => None,
        };
        let end = match end {
            Some(end) => return Ok(end),
            None if stopped() => Ended::Stopped,
            None if start.elapsed() > limit => Ended::TimedOut,
            None => continue,
        };
        child.kill()?;
        child.wait()?;
        return Ok(end);
    }
}

fn forward(from: impl Read + Send + 'static, to: Sender<Line>, kind: fn(String) -> Line) {
    std::thread::spawn(move || {
        let mut reader = BufReader::new(from);
        let mut bytes = Vec::new();
        while reader.read_until(b'\n', &mut bytes).is_ok_and(|length| length > 0) {
            if to.send(kind(String::from_utf8_lossy(&bytes).trim_end().to_owned())).is_err() {
                return;
            }
            bytes.clear();
        }
    });
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    fn shell(script: &str, limit: f64) -> (Ended, Vec<String>) {
        let mut all = Vec::new();
        let ended = run_limited(
            Command::new("sh").args(["-c", script]),
            Duration::from_secs_f64(limit),
            || false,
            |l| {
                let (Line::Out(text) | Line::Error(text)) = l;
                all.push(text);
            },
        );
        (ended.expect("there is a shell"), all)
    }

    #[test]
    fn output_and_status_arrive_and_the_limit_is_kept() {
        let (ended, lines) = shell("echo a; echo b >&2; exit 3", 20.0);
        assert!(matches!(ended, Ended::Itself(status) if status.code() == Some(3)));
        assert!(lines.contains(&"a".to_owned()) && lines.contains(&"b".to_owned()));
        let start = Instant::now();
        assert!(matches!(shell("exec sleep 20", 0.2).0, Ended::TimedOut));
        assert!(start.elapsed().as_secs_f64() < 10.0);
        let stopped = run_limited(Command::new("sleep").arg("20"), Duration::MAX, || true, |_| ());
        assert!(matches!(stopped, Ok(Ended::Stopped)));
    }
}
