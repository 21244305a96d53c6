#pragma once

namespace terravox {

/// Sends warnings and errors to standard error, unless set_log_level() has been called.
void set_up_log_once();

}  // namespace terravox
