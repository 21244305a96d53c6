#pragma once

#include <string>
#include <string_view>

namespace terravox::util {

/// A text as it must stand in HTML or XML, within an element or a quoted attribute.
[[nodiscard]] inline std::string escaped_markup(std::string_view text) {
    std::string out;
    for (const char c : text) {
        switch (c) {
            case '&': out += "&amp;"; break;
            case '<': out += "&lt;"; break;
            case '>': out += "&gt;"; break;
            case '"': out += "&quot;"; break;
            default: out += c; break;
        }
    }
    return out;
}

}  // namespace terravox::util
