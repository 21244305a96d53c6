#include "common/util/json_text.hpp"

#include <nlohmann/json.hpp>

namespace terravox::util {

bool has_more_json_levels(std::string_view text, int levels) noexcept {
    int open = 0;
    bool is_in_string = false;
    for (std::size_t i = 0; i < text.size(); ++i) {
        switch (text[i]) {
            case '"': is_in_string = !is_in_string; break;
            case '\\': i += is_in_string ? 1 : 0; break;
            case '[':
            case '{':
                if (!is_in_string && ++open > levels)
                    return true;
                break;
            case ']':
            case '}': open -= is_in_string ? 0 : 1; break;
            default: break;
        }
    }
    return false;
}

nlohmann::json parse_json(std::string_view text, int levels) {
    if (has_more_json_levels(text, levels))
        return nlohmann::json::value_t::discarded;
    return nlohmann::json::parse(text, nullptr, false);
}

}  // namespace terravox::util
