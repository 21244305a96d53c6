#pragma once

#include <terravox/api.hpp>

#include <stdexcept>
#include <string>

namespace terravox {

/// A request cannot be met. The message is one line: attempt, object, value, allowed range.
class TERRAVOX_API Error : public std::runtime_error {
public:
    using std::runtime_error::runtime_error;
    ~Error() override;
};

/// The request itself is invalid: an unknown field, a value out of range, a missing CRS.
class TERRAVOX_API UsageError : public Error {
public:
    using Error::Error;
    ~UsageError() override;
};

/// The caller has stopped the call (Control::stop).
class TERRAVOX_API Stopped : public Error {
public:
    using Error::Error;
    ~Stopped() override;
};

}  // namespace terravox
