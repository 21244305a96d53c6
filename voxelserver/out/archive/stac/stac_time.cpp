#include "voxelserver/out/archive/stac/stac_time.hpp"

#include <algorithm>
#include <chrono>
#include <optional>
#include <string_view>

#include "common/util/error.hpp"

namespace terravox::stac {
namespace {

bool has_form(std::string_view text, std::string_view form) {
    return std::equal(text.begin(), text.end(), form.begin(), form.end(),
                      [](char c, char f) { return f == '0' ? c >= '0' && c <= '9' : c == f; });
}

/// @return a number of digits
unsigned number_at(std::string_view text, std::size_t begin, std::size_t digits) {
    unsigned out = 0;
    for (const char c : text.substr(begin, digits))
        out = out * 10 + static_cast<unsigned>(c - '0');
    return out;
}

/// The first and the last second of a date, or twice an instant.
std::optional<StacTime> time_of(std::string_view text) {
    constexpr std::string_view kDate = "0000-00-00";
    const bool is_date = has_form(text, kDate);
    if (!is_date && !has_form(text, "0000-00-00T00:00:00Z"))
        return std::nullopt;
    const std::chrono::year_month_day day{
        std::chrono::year(static_cast<int>(number_at(text, 0, 4))),
        std::chrono::month(number_at(text, 5, 2)), std::chrono::day(number_at(text, 8, 2))};
    if (!day.ok())
        return std::nullopt;
    const std::string whole(text);
    if (is_date)
        return StacTime{whole + "T00:00:00Z", whole + "T23:59:59Z"};
    if (number_at(text, 11, 2) > 23 || number_at(text, 14, 2) > 59 || number_at(text, 17, 2) > 59)
        return std::nullopt;
    return StacTime{whole, whole};
}

}  // namespace

StacTime stac_time(const std::string& text) {
    const std::size_t slash = std::min(text.find('/'), text.size());
    const auto first = time_of(std::string_view(text).substr(0, slash));
    const auto last =
        slash == text.size() ? first : time_of(std::string_view(text).substr(slash + 1));
    // Texts of one form sort by time.
    if (!first || !last || last->end < first->start)
        throw util::UsageError("stac: --datetime " + text +
                               "; allowed: 2023-04-01, 2023-04-01T10:30:00Z, or two of these with "
                               "a slash, the earlier first");
    return {first->start, last->end};
}

}  // namespace terravox::stac
