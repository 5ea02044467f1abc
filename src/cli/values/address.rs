//! Addresses to listen on.

use std::net::{IpAddr, SocketAddr};

/// Parses an address with a port; without one, the system chooses it.
pub(crate) fn address(text: &str) -> Result<SocketAddr, String> {
    let text = text.trim();
    let with_port = || text.parse::<SocketAddr>().ok();
    let without = || text.parse::<IpAddr>().ok().map(|ip| SocketAddr::new(ip, 0));
    let expected = "expected an address of this machine and a port, such as 127.0.0.1:8000";
    with_port().or_else(without).ok_or_else(|| expected.into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses() {
        let check = |text: &str, expected: Option<&str>| {
            let found = address(text).ok().map(|address| address.to_string());
            assert_eq!(found.as_deref(), expected, "{text}");
        };
        check("127.0.0.1:8000", Some("127.0.0.1:8000"));
        check("0.0.0.0", Some("0.0.0.0:0"));
        check("[::1]:80", Some("[::1]:80"));
        check("::1", Some("[::1]:0"));
        for wrong in ["", "8000", ":8000", "localhost:8000", "127.0.0.1:99999"] {
            check(wrong, None);
        }
    }
}
