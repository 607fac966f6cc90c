//! The person beside the bench, reached through a front end.

use std::sync::Arc;

use async_trait::async_trait;
use isolux_scan::{Operator, OperatorRequest};

type Ask = dyn Fn(&str) -> Result<String, String> + Send + Sync;

/// Asks through a function of the front end that blocks until the person answers.
#[derive(Clone)]
pub struct ByFunction(Arc<Ask>);

impl ByFunction {
    /// `ask` shows the words and returns who did it, or why not.
    pub fn new(ask: impl Fn(&str) -> Result<String, String> + Send + Sync + 'static) -> Self {
        Self(Arc::new(ask))
    }
}

#[async_trait]
impl Operator for ByFunction {
    async fn carry_out(&self, request: &OperatorRequest) -> Result<String, String> {
        let (answer, wait) = tokio::sync::oneshot::channel();
        let (ask, prompt) = (self.0.clone(), request.prompt.clone());
        // A thread of its own, not the runtime's: an interrupted scan must not wait for a person who is at lunch.
        std::thread::spawn(move || {
            let _ = answer.send(ask(&prompt));
        });
        wait.await.unwrap_or_else(|_| Err("the question was lost".to_owned()))
    }
}
