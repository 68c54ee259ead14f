//! A controller in another process, asked line by line.

use super::wire::{self, Answer, Question};
use super::{Controller, ControllerError, Description, Inputs, Outputs, Setup};

/// How much of a bad answer an error shows, in characters.
const SHOWN: usize = 120;

/// Why there is no answer, in one sentence.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Lost {
    /// The other side cannot be reached, or has ended.
    Gone(String),
    /// It runs, and has not answered in time.
    Silent(String),
}

impl From<Lost> for ControllerError {
    fn from(lost: Lost) -> Self {
        match lost {
            Lost::Gone(reason) => Self::Transport { reason },
            Lost::Silent(reason) => Self::Silent { reason },
        }
    }
}

/// A line to the other side, and the line that it answers.
///
/// The transport belongs to the caller: it starts the process, keeps what it writes to its error
/// output, and ends it when an answer takes too long. This crate knows no processes and no clock.
pub trait LockStep: Send {
    /// Sends one line (without its end) and waits for one line (returned without its end).
    ///
    /// # Errors
    /// When the other side is gone or too late.
    fn exchange(&mut self, line: &str) -> Result<String, Lost>;

    /// What the other side said last besides its answers, for example on its error output; nothing
    /// if it said nothing. It is shown when a controller reports an error.
    fn last_words(&mut self) -> String {
        String::new()
    }
}

/// A controller that is spoken to over a [`LockStep`] transport.
pub struct RemoteController<T> {
    transport: T,
    description: Description,
}

impl<T: LockStep> RemoteController<T> {
    /// Greets the controller and learns what it is.
    ///
    /// # Errors
    /// When it cannot be reached, speaks another version or does not speak the protocol.
    pub fn connect(mut transport: T) -> Result<Self, ControllerError> {
        let question = Question::Hello {
            protocol: wire::VERSION,
        };
        let answer = ask(&mut transport, &question)?;
        let Answer::Hello {
            protocol,
            name,
            version,
            sends,
            receives,
            reports,
        } = answer
        else {
            return Err(unexpected(&question, "a `hello`"));
        };
        if protocol != wire::VERSION {
            return Err(ControllerError::Protocol {
                asked: question.name(),
                problem: format!(
                    "it speaks version {protocol}, and version {} is needed",
                    wire::VERSION
                ),
            });
        }
        Ok(Self {
            transport,
            description: wire::description(name, version, sends, receives, reports),
        })
    }

    /// The transport, when the controller is no longer needed.
    pub fn into_transport(self) -> T {
        self.transport
    }
}

impl<T: LockStep> Controller for RemoteController<T> {
    fn describe(&self) -> &Description {
        &self.description
    }

    fn set_up(&mut self, setup: &Setup) -> Result<(), ControllerError> {
        let question = Question::setup(setup);
        match ask(&mut self.transport, &question)? {
            Answer::Ready {} => Ok(()),
            _ => Err(unexpected(&question, "`ready`")),
        }
    }

    fn tick(&mut self, inputs: &Inputs) -> Result<Outputs, ControllerError> {
        let question = Question::tick(inputs);
        let Answer::Commands {
            commands,
            messages,
            reports,
            finished,
        } = ask(&mut self.transport, &question)?
        else {
            return Err(unexpected(&question, "`commands`"));
        };
        wire::outputs(&self.description, commands, messages, reports, finished).map_err(|problem| {
            ControllerError::Protocol {
                asked: question.name(),
                problem,
            }
        })
    }

    fn end(&mut self) -> Result<(), ControllerError> {
        let question = Question::End {};
        match ask(&mut self.transport, &question)? {
            Answer::Ended {} => Ok(()),
            _ => Err(unexpected(&question, "`ended`")),
        }
    }
}

/// One exchange; an error that the controller reports is an error.
fn ask(transport: &mut impl LockStep, question: &Question<'_>) -> Result<Answer, ControllerError> {
    let protocol = |problem: String| ControllerError::Protocol {
        asked: question.name(),
        problem,
    };
    let line = serde_json::to_string(question).map_err(|error| protocol(error.to_string()))?;
    let answer = transport.exchange(&line)?;
    match serde_json::from_str(&answer) {
        Ok(Answer::Error { message }) => {
            let words = transport.last_words();
            let separator = if words.is_empty() { "" } else { "\n" };
            let message = format!("{message}{separator}{words}");
            Err(ControllerError::Failed { message })
        }
        Ok(answer) => Ok(answer),
        Err(error) => {
            let shown: String = answer.trim_end().chars().take(SHOWN).collect();
            Err(protocol(format!("{error} in `{shown}`")))
        }
    }
}

fn unexpected(question: &Question<'_>, wanted: &str) -> ControllerError {
    ControllerError::Protocol {
        asked: question.name(),
        problem: format!("{wanted} was expected"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::VecDeque;

    /// Answers from a list and keeps what it was asked.
    #[derive(Default)]
    struct Script {
        answers: VecDeque<&'static str>,
        asked: Vec<String>,
    }

    impl LockStep for Script {
        fn exchange(&mut self, line: &str) -> Result<String, Lost> {
            self.asked.push(line.to_owned());
            let answer = self.answers.pop_front();
            answer
                .map(str::to_owned)
                .ok_or_else(|| Lost::Gone("it has ended".to_owned()))
        }
    }

    const HELLO: &str = r#"{"type":"hello","protocol":1,"name":"n","version":"2",
        "sends":["done"],"reports":{"state":{"enumeration":{"names":["go","stop"]}}}}"#;

    fn connected(answers: &[&'static str]) -> Result<RemoteController<Script>, ControllerError> {
        let answers = std::iter::once(HELLO).chain(answers.iter().copied());
        RemoteController::connect(Script {
            answers: answers.collect(),
            asked: Vec::new(),
        })
    }

    #[test]
    fn an_episode_goes_over_the_wire_and_missing_numbers_are_null() {
        let mut controller = connected(&[
            r#"{"type":"ready"}"#,
            r#"{"type":"commands","commands":{"drive":{"speed":0.25}},"reports":{"state":"stop"},"finished":true}"#,
            r#"{"type":"ended"}"#,
        ])
        .unwrap();
        controller.set_up(&Setup::default()).unwrap();
        let mut inputs = Inputs::at(0.1);
        inputs.insert("lidar", 0.05, [("ranges", vec![1.5, f64::NAN])]);
        let outputs = controller.tick(&inputs).unwrap();
        assert_eq!(outputs.commands["drive"]["speed"], 0.25);
        assert_eq!(outputs.reports["state"], 1.0);
        assert!(outputs.finished);
        controller.end().unwrap();
        let asked = controller.into_transport().asked;
        assert_eq!(
            asked[2],
            r#"{"type":"tick","time_secs":0.1,"sensors":{"lidar":{"time_secs":0.05,"values":{"ranges":[1.5,null]}}},"messages":[]}"#
        );
        assert_eq!(asked[3], r#"{"type":"end"}"#);
    }

    #[test]
    fn what_breaks_the_protocol_is_said_with_the_question() {
        let tick = |answer: &'static str| {
            let mut controller = connected(&[answer]).unwrap();
            controller.tick(&Inputs::at(0.0)).unwrap_err().to_string()
        };
        assert!(tick("nonsense").contains("`tick`"));
        assert!(tick(r#"{"type":"ready"}"#).contains("`commands` was expected"));
        assert!(tick(r#"{"type":"commands","comands":{}}"#).contains("comands"));
        assert!(tick(r#"{"type":"commands","reports":{"mood":1}}"#).contains("`mood`"));
        assert!(tick(r#"{"type":"commands","reports":{"state":"fly"}}"#).contains("`fly`"));
        assert!(tick(r#"{"type":"commands","reports":{"state":1}}"#).contains("another kind"));
        assert!(tick(r#"{"type":"error","message":"no map"}"#).contains("failed: no map"));
        let mut gone = connected(&[]).unwrap();
        assert!(gone.end().unwrap_err().to_string().contains("it has ended"));
    }

    #[test]
    fn another_version_is_refused() {
        let transport = Script {
            answers: [r#"{"type":"hello","protocol":2,"name":"n","version":"1"}"#].into(),
            asked: Vec::new(),
        };
        let error = RemoteController::connect(transport).err().unwrap();
        assert!(error.to_string().contains("version 2"));
    }
}
