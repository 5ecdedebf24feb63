//! Files as editors name them, and as the rest of the program does.

use std::str::FromStr;

use lsp_types::Uri;

/// Returns the path of a `file:` address; other addresses (a buffer that was never saved) have none.
pub(super) fn path_of(uri: &Uri) -> Option<String> {
    let rest = uri.as_str().strip_prefix("file://")?;
    let path = decoded(rest.get(rest.find('/')?..)?)?;
    // `/c:/lab/a.hatp` is `c:/lab/a.hatp`.
    let is_drive = matches!(path.as_bytes(), [b'/', letter, b':', ..] if letter.is_ascii_alphabetic());
    Some(if is_drive { path.get(1..)?.to_owned() } else { path })
}

/// Returns the address of an absolute path.
pub(super) fn uri_of(path: &str) -> Option<Uri> {
    let mut address = String::from("file://");
    if !path.starts_with('/') {
        address.push('/');
    }
    for byte in path.bytes() {
        match byte {
            b'A'..=b'Z' | b'a'..=b'z' | b'0'..=b'9' | b'/' | b'-' | b'.' | b'_' | b'~' => address.push(byte as char),
            _ => address.push_str(&format!("%{byte:02X}")),
        }
    }
    Uri::from_str(&address).ok()
}

/// Returns the text with `%C3%A9` as `é`.
fn decoded(text: &str) -> Option<String> {
    let mut bytes = Vec::new();
    let mut rest = text.as_bytes();
    while let Some((first, after)) = rest.split_first() {
        rest = after;
        match (first, after) {
            (b'%', [high, low, after @ ..]) => {
                let digit = |c: u8| char::from(c).to_digit(16);
                bytes.push(u8::try_from(digit(*high)? * 16 + digit(*low)?).ok()?);
                rest = after;
            }
            _ => bytes.push(*first),
        }
    }
    String::from_utf8(bytes).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_and_addresses_are_one_another() {
        for (path, address) in [
            ("/lab/a.hatp", "file:///lab/a.hatp"),
            ("/lab é/%.hatp", "file:///lab%20%C3%A9/%25.hatp"),
            ("c:/lab/a.hatp", "file:///c%3A/lab/a.hatp"),
        ] {
            let uri = uri_of(path).expect("an address");
            assert_eq!(uri.as_str(), address);
            assert_eq!(path_of(&uri).as_deref(), Some(path));
        }
        let unsaved = Uri::from_str("untitled:Untitled-1").expect("an address");
        assert_eq!(path_of(&unsaved), None);
    }
}
