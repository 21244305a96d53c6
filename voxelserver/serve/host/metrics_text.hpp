#pragma once

#include <string>
#include <string_view>
#include <utility>

#include "common/util/text.hpp"
#include "voxelserver/serve/host/message.hpp"

namespace terravox::http {

/// name="value"
[[nodiscard]] inline std::string metrics_label(const char* name, std::string_view value) {
    std::string out = std::string(name) + "=\"";
    for (const char c : value) {
        if (c == '\\' || c == '"')
            out += '\\';
        out += c == '\n' ? ' ' : c;
    }
    return out + "\"";
}

/// Writes metrics for monitoring systems, one after the other; all values of a family are
/// consecutive, as the format requires. Ref: Prometheus, "Exposition formats", text format 0.0.4.
class MetricsText {
public:
    /// Begins a family.
    /// @param type "counter", "gauge", "histogram"
    void family(const char* name, const char* type, const char* help) {
        m_name = name;
        m_out +=
            std::string("# HELP ") + name + " " + help + "\n# TYPE " + name + " " + type + "\n";
    }
    /// Adds a value to the family.
    /// @param labels as metrics_label() makes them, with commas between them
    /// @param tail of the name, for histograms
    void value(double number, const std::string& labels = "", const char* tail = "") {
        m_out += m_name + tail + (labels.empty() ? "" : "{" + labels + "}") + " " +
                 util::number_text(number, 17) + "\n";
    }
    /// A family of one value, without labels.
    void one(const char* name, const char* type, const char* help, double number) {
        family(name, type, help);
        value(number);
    }
    [[nodiscard]] std::string take() { return std::move(m_out); }
    /// A reply with the text, which must not be cached.
    [[nodiscard]] Response take_reply() {
        return reply(200, "text/plain; version=0.0.4; charset=utf-8", take())
            .add("Cache-Control", "no-store");
    }

private:
    std::string m_name;
    std::string m_out;
};

}  // namespace terravox::http
