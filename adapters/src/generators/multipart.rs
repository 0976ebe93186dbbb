//! Forms with files in them, as servers take uploads.

use trace::Digest;

/// One field of a form.
#[derive(Clone, Copy, Debug)]
pub enum Field<'a> {
    /// A word.
    Text(&'a str, &'a str),
    /// A PNG file under the name `photo.png`.
    Png(&'a str, &'a [u8]),
}

/// A form as a body and its content type. The same fields give the same bytes: the line between
/// fields comes from what is in them.
pub fn form(fields: &[Field<'_>]) -> (String, Vec<u8>) {
    let mut all = vec![];
    for field in fields {
        match field {
            Field::Text(name, value) => all.extend([name.as_bytes(), value.as_bytes()].concat()),
            Field::Png(name, bytes) => all.extend([name.as_bytes(), bytes].concat()),
        }
    }
    let line = format!("kinfold-{}", Digest::of(&all).short());
    let mut body = vec![];
    for field in fields {
        body.extend_from_slice(format!("--{line}\r\n").as_bytes());
        match field {
            Field::Text(name, value) => body.extend_from_slice(
                format!("content-disposition: form-data; name=\"{name}\"\r\n\r\n{value}\r\n")
                    .as_bytes(),
            ),
            Field::Png(name, bytes) => {
                let head = format!(
                    "content-disposition: form-data; name=\"{name}\"; filename=\"photo.png\"\r\n\
                     content-type: image/png\r\n\r\n"
                );
                body.extend_from_slice(head.as_bytes());
                body.extend_from_slice(bytes);
                body.extend_from_slice(b"\r\n");
            }
        }
    }
    body.extend_from_slice(format!("--{line}--\r\n").as_bytes());
    (format!("multipart/form-data; boundary={line}"), body)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_form_is_the_same_each_time_and_its_line_is_in_none_of_its_fields() {
        let fields = [Field::Text("type", "input"), Field::Png("image", b"\x89PNG\r\n--kinfold")];
        let (media_type, body) = form(&fields);
        assert_eq!((media_type.clone(), body.clone()), form(&fields));
        let line = media_type.split_once("boundary=").unwrap().1;
        let text = String::from_utf8_lossy(&body);
        assert_eq!(text.matches(line).count(), 3);
        assert!(text.ends_with(&format!("--{line}--\r\n")));
    }
}
