#pragma once

#include <functional>
#include <string>

namespace terravox::test {

struct ChildEnd {
    int status = 0;  ///< of waitpid
    std::string error_output;
};

/// Runs `work` in a forked process that ends with exit code 0 when `work` returns, and collects
/// what it writes to standard error. Uncaught exceptions end it as they end our programs.
ChildEnd run_in_child(const std::function<void()>& work);

}  // namespace terravox::test
