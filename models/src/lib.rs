//! Networks of pneumatic muscles and compliant members.
