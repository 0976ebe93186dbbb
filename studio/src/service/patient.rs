//! Connections: so many at a time, and none that does nothing for long.

use std::io;
use std::net::SocketAddr;
use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll};
use std::time::Duration;

use axum::serve::Listener;
use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::{OwnedSemaphorePermit, Semaphore};
use tokio::time::{Instant, Sleep, sleep};

/// Bytes that must come for a connection to count as one that does something: a guess, about what a third of
/// a second brings over a poor connection.
const SOMETHING: usize = 16 << 10;
/// How long is waited after the operating system refused a connection, which it does when it has no more.
const PAUSE: Duration = Duration::from_millis(100);

/// Takes connections in, so many at a time.
pub(super) struct Patience {
    listener: TcpListener,
    places: Arc<Semaphore>,
    longest: Duration,
}

impl Patience {
    pub(super) fn new(listener: TcpListener, most: usize, longest: Duration) -> Self {
        Self { listener, places: Arc::new(Semaphore::new(most.max(1))), longest }
    }
}

impl Listener for Patience {
    type Io = Watched;
    type Addr = SocketAddr;

    async fn accept(&mut self) -> (Watched, SocketAddr) {
        loop {
            let Ok(place) = Arc::clone(&self.places).acquire_owned().await else {
                // Nobody closes it.
                sleep(PAUSE).await;
                continue;
            };
            match self.listener.accept().await {
                Ok((stream, from)) => {
                    let (due, longest) = (Box::pin(sleep(self.longest)), self.longest);
                    return (Watched { stream, due, longest, got: 0, _place: place }, from);
                }
                Err(_) => sleep(PAUSE).await,
            }
        }
    }

    fn local_addr(&self) -> io::Result<SocketAddr> {
        self.listener.local_addr()
    }
}

/// A connection that ends when neither an answer goes out nor enough comes in for too long.
pub(super) struct Watched {
    stream: TcpStream,
    due: Pin<Box<Sleep>>,
    longest: Duration,
    got: usize,
    _place: OwnedSemaphorePermit,
}

impl Watched {
    fn is_over(&mut self, context: &mut Context<'_>) -> io::Result<()> {
        match self.due.as_mut().poll(context) {
            Poll::Ready(()) => Err(io::ErrorKind::TimedOut.into()),
            Poll::Pending => Ok(()),
        }
    }

    fn does_something(&mut self) {
        self.got = 0;
        self.due.as_mut().reset(Instant::now() + self.longest);
    }
}

impl AsyncRead for Watched {
    fn poll_read(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        buffer: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        self.is_over(context)?;
        let before = buffer.filled().len();
        let read = Pin::new(&mut self.stream).poll_read(context, buffer);
        self.got += buffer.filled().len() - before;
        if self.got >= SOMETHING {
            self.does_something();
        }
        read
    }
}

impl AsyncWrite for Watched {
    fn poll_write(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        bytes: &[u8],
    ) -> Poll<io::Result<usize>> {
        self.is_over(context)?;
        let written = Pin::new(&mut self.stream).poll_write(context, bytes);
        if matches!(written, Poll::Ready(Ok(1..))) {
            self.does_something();
        }
        written
    }

    fn poll_flush(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_flush(context)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_shutdown(context)
    }
}
