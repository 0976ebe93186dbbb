//! Which addresses are public: what a service's answer names must not lead into the user's own net.

use std::net::{IpAddr, Ipv4Addr, Ipv6Addr};

/// Whether an address belongs to the public internet: no loopback, private, link-local (where cloud
/// machines keep their metadata), carrier, multicast, documentation or reserved range, and no IPv4
/// address in IPv6 clothes that would be one.
///
/// Source: the IANA special-purpose address registries.
pub fn is_public(address: IpAddr) -> bool {
    match address {
        IpAddr::V4(v4) => is_public_v4(v4),
        IpAddr::V6(v6) => is_public_v6(v6),
    }
}

fn is_public_v4(a: Ipv4Addr) -> bool {
    let [first, second, third, _] = a.octets();
    let special = match (first, second, third) {
        (0 | 10 | 127, ..) | (169, 254, _) | (192, 168, _) => true,
        (100, 64..=127, _) | (172, 16..=31, _) | (198, 18..=19, _) => true,
        (192, 0, 0 | 2) | (192, 88, 99) | (198, 51, 100) | (203, 0, 113) => true,
        _ => first >= 224,
    };
    !special
}

fn is_public_v6(a: Ipv6Addr) -> bool {
    let s = a.segments();
    if let Some(v4) = a.to_ipv4_mapped() {
        return is_public_v4(v4);
    }
    let carried = match s {
        [0x64, 0xff9b, 0, 0, 0, 0, high, low] | [0x2002, high, low, ..] => Some([high, low]),
        _ => None,
    };
    if let Some([high, low]) = carried {
        let bits = u32::from(high) << 16 | u32::from(low);
        return is_public_v4(Ipv4Addr::from_bits(bits));
    }
    // Only 2000::/3 is handed out; of it 2001::/23 is for protocols and 2001:db8::/32 for books.
    let protocols = s[0] == 0x2001 && (s[1] < 0x200 || s[1] == 0xdb8);
    s[0] & 0xe000 == 0x2000 && !protocols
}

/// Whether two addresses lead to the same server: scheme, host and port.
pub fn same_origin(one: &str, other: &str) -> bool {
    let origin = |text: &str| {
        let uri: ureq::http::Uri = text.parse().ok()?;
        Some((uri.scheme()?.clone(), uri.host()?.to_ascii_lowercase(), uri.port_u16()))
    };
    origin(one).is_some() && origin(one) == origin(other)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_house_and_its_neighbours_are_not_public() {
        let inside = [
            "127.0.0.1",
            "0.0.0.0",
            "10.1.2.3",
            "172.16.0.1",
            "172.31.255.255",
            "192.168.1.1",
            "169.254.169.254",
            "100.64.0.1",
            "192.0.2.9",
            "198.18.0.1",
            "224.0.0.1",
            "255.255.255.255",
            "::1",
            "::",
            "fe80::1",
            "fd00::1",
            "ff02::1",
            "::ffff:10.0.0.1",
            "64:ff9b::7f00:1",
            "2002:a00:1::",
            "2001:db8::1",
            "2001::1",
            "::7f00:1",
        ];
        for text in inside {
            assert!(!is_public(text.parse().unwrap()), "{text}");
        }
    }

    #[test]
    fn hosts_of_the_world_are_public() {
        let outside = ["1.1.1.1", "172.32.0.1", "100.128.0.1", "2606:4700::1111", "::ffff:8.8.8.8"];
        for text in outside {
            assert!(is_public(text.parse().unwrap()), "{text}");
        }
    }

    #[test]
    fn another_port_scheme_or_host_is_another_server() {
        let base = "http://127.0.0.1:7860/app";
        assert!(same_origin(base, "http://127.0.0.1:7860/file=x.glb?a=b"));
        for other in ["https://127.0.0.1:7860/", "http://127.0.0.1:80/", "http://a@b:7860", "x"] {
            assert!(!same_origin(base, other), "{other}");
        }
    }
}
