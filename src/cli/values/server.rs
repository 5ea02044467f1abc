//! Places on the network to connect to.

/// Parses a host and a port.
pub(crate) fn server(text: &str) -> Result<String, String> {
    let text = text.trim();
    let parts = text.rsplit_once(':').filter(|(host, port)| {
        let is_port = port.parse::<u16>().is_ok_and(|port| port > 0);
        is_port && !host.is_empty() && !host.contains(char::is_whitespace)
    });
    let expected = || "expected a host and a port, such as localhost:14158".to_owned();
    parts.map(|_| text.to_owned()).ok_or_else(expected)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn servers() {
        for right in ["localhost:14158", "10.0.0.1:80", "[::1]:14158"] {
            assert_eq!(server(right).as_deref(), Ok(right));
        }
        for wrong in ["", "localhost", ":14158", "localhost:0", "a b:1", "localhost:99999"] {
            assert!(server(wrong).is_err(), "{wrong}");
        }
    }
}
