//! The server as a stranger meets it: who is refused, what is answered.

use csalf_studio::server::{Studio, Unbound};
use serde_json::Value;
use std::io::{Read, Write};
use std::net::TcpStream;

/// A studio that serves; its port and token.
fn studio(file: Option<(&str, &[u8])>) -> (u16, String) {
    let studio = Studio::bind(0, file).unwrap();
    let url = studio.url();
    std::thread::spawn(move || studio.serve());
    let rest = url.strip_prefix("http://127.0.0.1:").unwrap();
    let (port, path) = rest.split_once('/').unwrap();
    (port.parse().unwrap(), path.trim_end_matches('/').to_owned())
}

/// Sends a request by hand; status, head and body of the answer.
fn ask(port: u16, method: &str, path: &str, headers: &str, body: &[u8]) -> (u16, String, Vec<u8>) {
    let mut stream = TcpStream::connect(("127.0.0.1", port)).unwrap();
    let n = body.len();
    write!(stream, "{method} {path} HTTP/1.1\r\n{headers}Content-Length: {n}\r\nConnection: close\r\n\r\n")
        .unwrap();
    stream.write_all(body).unwrap();
    let mut answer = Vec::new();
    stream.read_to_end(&mut answer).unwrap();
    let end = answer.windows(4).position(|w| w == b"\r\n\r\n").unwrap();
    let head = String::from_utf8(answer[..end].to_vec()).unwrap();
    let status = head.split(' ').nth(1).unwrap().parse().unwrap();
    (status, head.to_lowercase(), answer[end + 4..].to_vec())
}

fn post(port: u16, path: &str, body: &[u8]) -> (u16, String, Vec<u8>) {
    ask(port, "POST", path, &format!("Host: 127.0.0.1:{port}\r\n"), body)
}

const JOB: &str =
    r#"{"loops": [{"kind": "outer", "nodes": [[0,0],[1,0],[2,0],[2,1],[2,2],[1,2],[0,2],[0,1]]}]}"#;

fn head(reply: &[u8]) -> Value {
    let n = u32::from_le_bytes(reply[..4].try_into().unwrap()) as usize;
    serde_json::from_slice(&reply[4..4 + n]).unwrap()
}

#[test]
fn only_who_knows_the_token_and_comes_from_here_gets_in() {
    let (port, token) = studio(None);
    let host = format!("Host: 127.0.0.1:{port}\r\n");
    let wrong = "0".repeat(token.len());
    let cases = [
        (format!("/{token}/"), host.clone(), 200),
        (format!("/{token}/"), format!("Host: localhost:{port}\r\n"), 200),
        (format!("/{token}/api/start"), format!("{host}Origin: http://127.0.0.1:{port}\r\n"), 200),
        (format!("/{token}/nothing.js"), host.clone(), 404),
        (format!("/{wrong}/"), host.clone(), 403),
        (format!("/{wrong}/api/start"), host.clone(), 403),
        (format!("/{}/api/start", &token[1..]), host.clone(), 403),
        ("/".to_owned(), host.clone(), 403),
        ("/api/start".to_owned(), host.clone(), 403),
        (format!("/{token}/api/start"), format!("{host}Origin: http://example.org\r\n"), 403),
        (format!("/{token}/api/start"), format!("{host}Origin: null\r\n"), 403),
        (format!("/{token}/api/start"), format!("{host}Origin: http://127.0.0.1:1\r\n"), 403),
        (format!("/{token}/"), format!("Host: rebound.example.org:{port}\r\n"), 403),
        (format!("/{token}/"), "Host: 127.0.0.1\r\n".to_owned(), 403),
    ];
    for (path, headers, status) in cases {
        let (got, head, body) = ask(port, "GET", &path, &headers, b"");
        assert_eq!(got, status, "{path} {headers}");
        assert!(head.contains("content-security-policy: default-src 'none'"), "{head}");
        if status == 403 {
            assert!(!String::from_utf8_lossy(&body).contains(&token));
        }
    }
    assert_ne!(studio(None).1, token);
}

#[test]
fn a_file_becomes_documents_a_mesh_and_files() {
    let (port, token) = studio(Some(("plate.json", JOB.as_bytes())));
    let (status, _, body) =
        ask(port, "GET", &format!("/{token}/api/start"), &format!("Host: 127.0.0.1:{port}\r\n"), b"");
    assert_eq!(status, 200);
    let opened: Value = serde_json::from_slice(&body).unwrap();
    let document = opened["documents"][0].to_string();
    assert_eq!(opened["documents"][0]["job"]["name"], "plate");

    let (status, _, reply) = post(port, &format!("/{token}/api/mesh"), document.as_bytes());
    assert_eq!(status, 200);
    let head = head(&reply);
    assert_eq!((&head["ok"], &head["n_quads"], &head["n_vertices"]), (&true.into(), &4.into(), &9.into()));
    assert_eq!(head["arrays"]["quads"][1], 16);
    assert_eq!(head["quality"]["min_sj"], 1.0);

    let (status, headers, file) = post(port, &format!("/{token}/api/export?format=vtu"), document.as_bytes());
    assert_eq!(status, 200);
    assert!(headers.contains("attachment; filename=\"plate.vtu\""), "{headers}");
    assert!(String::from_utf8_lossy(&file).contains("UnstructuredGrid"));
}

#[test]
fn what_cannot_be_read_is_told() {
    let (port, token) = studio(None);
    for (path, body, word) in [
        ("open?name=a.dxf", "nonsense", ""),
        ("open?name=a.xyz", "{}", "xyz"),
        ("open?name=a.json", "{", "line"),
        ("mesh", "{", "line"),
        ("mesh", r#"{"job": {"loops": 3}}"#, "loops"),
        ("export?format=vtu", r#"{"job": {"loops": []}}"#, "outer"),
        ("export?format=exe", &format!(r#"{{"job": {JOB}}}"#), "exe"),
    ] {
        let (status, _, answer) = post(port, &format!("/{token}/api/{path}"), body.as_bytes());
        let text = String::from_utf8(answer).unwrap();
        assert_eq!(status, 422, "{path}: {text}");
        assert!(text.contains(word), "{path}: {text}");
    }
}

#[test]
fn a_broken_file_or_a_taken_port_starts_no_server() {
    assert!(matches!(Studio::bind(0, Some(("a.json", b"{"))), Err(Unbound::File(_))));
    let (port, _) = studio(None);
    assert!(matches!(Studio::bind(port, None), Err(Unbound::Port(_))));
}
