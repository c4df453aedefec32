//! The lines of a log without their checksums, and logs from such lines.

use serde_json::Value;

/// Length of `{"crc":"01234567",`.
const HEAD: usize = 18;

/// The contents of the lines of a log, each as a JSON object.
pub fn contents(log: &[u8]) -> Vec<String> {
    let text = std::str::from_utf8(log).unwrap();
    text.lines().map(|line| format!("{{{}", &line[HEAD..])).collect()
}

/// The log with these lines, with the right checksums.
pub fn log_of(contents: &[String]) -> Vec<u8> {
    let mut log = Vec::new();
    let mut sum: u32 = 0;
    for content in contents {
        let rest = &content[1..];
        let mut hasher = crc32fast::Hasher::new();
        hasher.update(&sum.to_le_bytes());
        hasher.update(rest.as_bytes());
        sum = hasher.finalize();
        log.extend(format!("{{\"crc\":\"{sum:08x}\",{rest}\n").bytes());
    }
    log
}

/// The name of a line's event. Empty for the header, and for a line that repeats the last jog input.
pub fn event(content: &str) -> &str {
    let after = content.split_once("\"event\":").map_or("", |(_, after)| after);
    after.trim_start_matches(['{', '"']).split('"').next().unwrap_or_default()
}

/// Changes a line as JSON.
pub fn edit(content: &mut String, change: impl FnOnce(&mut Value)) {
    let mut value: Value = serde_json::from_str(content).unwrap();
    change(&mut value);
    *content = value.to_string();
}
