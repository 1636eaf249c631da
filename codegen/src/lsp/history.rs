//! The history of messages, which the program provides.

/// The history of messages in published releases, for hover texts.
pub trait History {
    /// The releases that contain a message, or one of its fields or constants, and the changes, as lines of text. The
    /// name of the message is its full ROS name, such as `px4_msgs/msg/VehicleStatus`.
    fn lines(&self, message: &str, item: Option<&str>) -> Vec<String>;
}
