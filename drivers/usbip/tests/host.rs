//! A host in user space attaches a device and uses it.

use isolux_usbip::{Bench, Model, Packing, Speed, Twin};
use tokio::io::{AsyncReadExt, AsyncWriteExt, DuplexStream};
use tokio::net::TcpStream;

/// A twin that sends back what it gets on endpoint 1, on endpoint 0x81.
fn echo() -> DuplexStream {
    let (host, mut twin) = tokio::io::duplex(1 << 16);
    tokio::spawn(async move {
        let mut frame = vec![0; 4096];
        while let Ok(count @ 1..) = twin.read(&mut frame).await {
            frame[0] = 0x81;
            twin.write_all(&frame[..count]).await.unwrap();
        }
    });
    host
}

fn model() -> Model {
    Model {
        id: (0x2457, 0x101E),
        release: 0x0002,
        strings: ["Ocean Optics".into(), "USB2000+".into(), "S1".into()],
        speed: Speed::High,
        endpoints: vec![0x01, 0x81, 0x82],
        packing: Packing::Transfers,
    }
}

fn submit(number: u32, endpoint: u8, to_host: bool, length: u32, setup: [u8; 8], data: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    for word in [
        1,
        number,
        0x0001_0002,
        u32::from(to_host),
        u32::from(endpoint),
        0,
        length,
        0,
        0,
        0,
    ] {
        bytes.extend(word.to_be_bytes());
    }
    bytes.extend(setup);
    bytes.extend(data);
    bytes
}

fn unlink(number: u32, forget: u32) -> Vec<u8> {
    let mut bytes = Vec::new();
    for word in [2, number, 0x0001_0002, 0, 0, forget] {
        bytes.extend(word.to_be_bytes());
    }
    bytes.resize(48, 0);
    bytes
}

/// Command, number, status and data of an answer.
async fn answer(stream: &mut TcpStream, to_host: bool) -> (u32, u32, i32, Vec<u8>) {
    let mut head = [0; 48];
    stream.read_exact(&mut head).await.unwrap();
    let word = |at: usize| u32::from_be_bytes(head[at..at + 4].try_into().unwrap());
    let mut data = vec![0; if to_host && word(0) == 3 { word(24) as usize } else { 0 }];
    stream.read_exact(&mut data).await.unwrap();
    (word(0), word(4), word(20) as i32, data)
}

async fn attach(port: u16) -> TcpStream {
    let mut stream = TcpStream::connect(("127.0.0.1", port)).await.unwrap();
    let mut request = vec![0x01, 0x11, 0x80, 0x03, 0, 0, 0, 0];
    request.extend(b"1-1");
    request.resize(40, 0);
    stream.write_all(&request).await.unwrap();
    let mut head = [0; 8];
    stream.read_exact(&mut head).await.unwrap();
    if head == [0x01, 0x11, 0, 3, 0, 0, 0, 0] {
        let mut description = [0; 312];
        stream.read_exact(&mut description).await.unwrap();
        assert_eq!(&description[256..259], b"1-1");
        assert_eq!(description[300..304], [0x24, 0x57, 0x10, 0x1E]);
    }
    stream
}

#[tokio::test]
async fn a_host_lists_attaches_reads_gives_up_and_loses_the_device() {
    let twin = Twin::new(model(), echo);
    let bench = Bench::bind(0, vec![twin.clone()]).await.unwrap();
    let port = bench.address().unwrap().port();
    tokio::spawn(bench.serve());

    let mut stream = TcpStream::connect(("127.0.0.1", port)).await.unwrap();
    stream.write_all(&[0x01, 0x11, 0x80, 0x05, 0, 0, 0, 0]).await.unwrap();
    let mut list = Vec::new();
    stream.read_to_end(&mut list).await.unwrap();
    assert_eq!(list.len(), 12 + 312 + 4);
    assert_eq!(list[8..12], [0, 0, 0, 1]);

    let mut host = attach(port).await;
    assert!(twin.is_attached());
    let device = [0x80, 6, 0, 1, 0, 0, 18, 0];
    host.write_all(&submit(1, 0, true, 18, device, &[])).await.unwrap();
    let (command, number, status, data) = answer(&mut host, true).await;
    assert_eq!((command, number, status, data.len(), data[8]), (3, 1, 0, 18, 0x57));

    // Nothing to read: the request waits, is given up, and what comes later goes to the next.
    host.write_all(&submit(2, 1, true, 512, [0; 8], &[])).await.unwrap();
    host.write_all(&unlink(3, 2)).await.unwrap();
    assert_eq!(answer(&mut host, true).await, (4, 3, -104, vec![]));
    host.write_all(&submit(4, 1, false, 3, [0; 8], b"abc")).await.unwrap();
    assert_eq!(answer(&mut host, false).await, (3, 4, 0, vec![]));
    host.write_all(&submit(5, 1, true, 512, [0; 8], &[])).await.unwrap();
    assert_eq!(answer(&mut host, true).await, (3, 5, 0, b"abc".to_vec()));

    // A stall reaches a read that waits already.
    host.write_all(&submit(6, 1, true, 512, [0; 8], &[])).await.unwrap();
    host.write_all(&submit(7, 0, true, 18, device, &[])).await.unwrap();
    answer(&mut host, true).await;
    twin.stall(0x81);
    assert_eq!(answer(&mut host, true).await, (3, 6, -32, vec![]));

    // A second host gets nothing while the first has it.
    let mut second = attach(port).await;
    assert_eq!(second.read(&mut [0; 1]).await.unwrap(), 0);

    twin.unplug();
    assert_eq!(host.read(&mut [0; 1]).await.unwrap(), 0, "the cable is out");
    let mut again = attach(port).await;
    again.write_all(&submit(1, 0, true, 18, device, &[])).await.unwrap();
    assert_eq!(answer(&mut again, true).await.2, 0);
}
