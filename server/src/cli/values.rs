//! Values of arguments that more than one command has, or that are more than a number.

use std::net::{Ipv4Addr, SocketAddr};

/// An address to listen on.
pub fn listen_address(text: &str) -> Result<SocketAddr, String> {
    let (host, port) = text.rsplit_once(':').unwrap_or(("", text));
    let this_machine = host.is_empty() || host.eq_ignore_ascii_case("localhost");
    let address = match port.parse() {
        Ok(port) if this_machine => Some((Ipv4Addr::LOCALHOST, port).into()),
        _ => text.parse().ok(),
    };
    address.ok_or_else(|| {
        "must be an IP address or localhost, and a port, such as 127.0.0.1:8080, localhost:8080, \
         [::1]:8080 or 8080"
            .to_owned()
    })
}

/// A number of threads, 1 to 1,024.
pub fn threads(text: &str) -> Result<usize, String> {
    text.parse()
        .ok()
        .filter(|number| (1..=1024).contains(number))
        .ok_or_else(|| "must be a whole number from 1 to 1024".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_address_to_listen_on_is_short_for_this_machine() {
        for (text, address) in [
            ("127.0.0.1:8080", "127.0.0.1:8080"),
            ("localhost:81", "127.0.0.1:81"),
            ("LocalHost:0", "127.0.0.1:0"),
            (":82", "127.0.0.1:82"),
            ("83", "127.0.0.1:83"),
            ("[::1]:84", "[::1]:84"),
            ("0.0.0.0:85", "0.0.0.0:85"),
        ] {
            let parsed = listen_address(text).map(|address| address.to_string());
            assert_eq!(parsed.as_deref(), Ok(address), "{text}");
        }
        for text in [
            "",
            "localhost",
            "127.0.0.1",
            "::1",
            "example.org:80",
            "65536",
            "[::1]",
        ] {
            assert!(listen_address(text).is_err(), "{text}");
        }
    }
}
