#include "voxelserver/serve/jobs/job_queue.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>

#include "common/util/error.hpp"
#include "common/util/json_text.hpp"
#include "common/util/text.hpp"
#include "common/voxel/analysis.hpp"

namespace terravox::jobs {
namespace {

using util::plain_number_text;

using nlohmann::json;

constexpr int kMaxSide = 65'536;
constexpr std::size_t kMaxObservers = 16;

[[noreturn]] void refuse(const std::string& what, const std::string& allowed) {
    throw util::UsageError("read the job: " + what + "; allowed: " + allowed);
}

/// A value for a message. Lists and objects are not printed: a value in many thousand brackets
/// would take more stack than the threads of a web server have.
std::string shown(const json& value) {
    constexpr std::size_t kMost = 40;
    return value.is_structured() ? std::string("an ") + value.type_name()
                                 : value.dump().substr(0, kMost);
}

bool is_digits(std::string_view text, std::string_view form) {
    if (text.size() != form.size())
        return false;
    for (std::size_t i = 0; i < text.size(); ++i)
        if (form[i] == '0' ? text[i] < '0' || text[i] > '9' : text[i] != form[i])
            return false;
    return true;
}

bool is_zone(std::string_view text) {
    const auto is_letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); };
    return !text.empty() && text.size() <= 40 && is_letter(text.front()) &&
           std::all_of(text.begin(), text.end(), [&](char c) {
               return is_letter(c) || (c >= '0' && c <= '9') ||
                      std::string_view("_+-/").find(c) != std::string_view::npos;
           });
}

/// Reads the members of a request, and notes which.
class RequestReader {
public:
    RequestReader(std::string_view body, const voxel::WorldInfo& world, const JobLimits& limits)
        : m_in(util::parse_json(body)), m_world(world), m_limits(limits) {
        if (!m_in.is_object())
            refuse("not a JSON object",
                   "{\"kind\": \"sun\", \"area\": [west, south, east, north]}");
    }

    JobRequest read() {
        read_kind();
        read_cells();
        if (m_terms->reads("analysis.surface"))
            word("surface", {"top", "ground"});
        if (m_terms->reads("analysis.thin_blocks"))
            if (const auto given = truth("thin_blocks"))
                add("thin-blocks", *given ? "yes" : "no");
        if (m_terms->reads("analysis.directions"))
            number("directions", "directions", 16, 1024, true);
        if (m_terms->reads("analysis.range_m"))
            number("range_m", "range-m", 0, 1e6);
        if (m_terms->reads("sun.date"))
            read_time();
        if (m_terms->reads("analysis.linke"))
            number("linke", "linke", 1, 10);
        if (m_terms->reads("analysis.target_m"))
            read_sight();
        for (const auto& [name, value] : m_in.items())
            if (!m_known.contains(name))
                refuse("'" + name.substr(0, 40) + "' of " + m_out.kind, names());
        return std::move(m_out);
    }

private:
    /// @return nullptr where it is not given
    const json* member(const char* name) {
        m_known.insert(name);
        const auto found = m_in.find(name);
        return found == m_in.end() ? nullptr : &*found;
    }
    [[nodiscard]] std::string names() const {
        std::string out;
        for (const std::string& name : m_known)
            out += (out.empty() ? "" : ", ") + name;
        return out;
    }
    void add(const std::string& option, const std::string& value) {
        m_out.words.push_back("--" + option + "=" + value);
    }

    static double to_number(const json& value, const std::string& name, double min, double max,
                            bool is_whole = false) {
        const double number = value.is_number() ? value.get<double>() : NAN;
        if (!(number >= min && number <= max) || (is_whole && number != std::floor(number)))
            refuse("'" + name + "' is " + shown(value), plain_number_text(min) + " to " +
                                                            plain_number_text(max) +
                                                            (is_whole ? ", whole" : ""));
        return number;
    }
    void number(const char* name, const char* option, double min, double max,
                bool is_whole = false) {
        if (const json* value = member(name))
            add(option, plain_number_text(to_number(*value, name, min, max, is_whole)));
    }
    void word(const char* name, std::initializer_list<std::string_view> words) {
        const json* value = member(name);
        if (value == nullptr)
            return;
        std::string allowed;
        for (const std::string_view one : words) {
            if (value->is_string() && value->get_ref<const std::string&>() == one)
                return add(name, std::string(one));
            allowed += (allowed.empty() ? "" : ", ") + std::string(one);
        }
        refuse("'" + std::string(name) + "' is " + shown(*value), allowed);
    }
    std::optional<bool> truth(const char* name) {
        const json* value = member(name);
        if (value == nullptr)
            return std::nullopt;
        if (!value->is_boolean())
            refuse("'" + std::string(name) + "' is " + shown(*value), "true, false");
        return value->get<bool>();
    }
    /// @param form 0: a digit
    void digits(const char* name, std::string_view form, const std::string& allowed) {
        const json* value = member(name);
        if (value == nullptr)
            return;
        if (!value->is_string() || !is_digits(value->get_ref<const std::string&>(), form))
            refuse("'" + std::string(name) + "' is " + shown(*value), allowed);
        add(name, value->get<std::string>());
    }

    void read_kind() {
        const json* kind = member("kind");
        if (kind != nullptr && kind->is_string())
            m_out.kind = kind->get<std::string>();
        m_terms = std::find_if(
            std::begin(voxel::kAnalyses), std::end(voxel::kAnalyses),
            [&](const auto& terms) { return !terms.help.empty() && terms.name == m_out.kind; });
        if (m_terms == std::end(voxel::kAnalyses))
            refuse(kind == nullptr ? "no 'kind'" : "'kind' is " + shown(*kind),
                   util::comma_list(voxel::list_analyses()));
    }

    void read_cells() {
        constexpr const char* kArea = "[west, south, east, north] in the world's CRS, or voxels";
        const json* area = member("area");
        if (area == nullptr || !area->is_array() || area->size() != 4)
            refuse("no 'area' of four numbers", kArea);
        std::array<double, 4> sides{};
        std::string text;
        for (std::size_t i = 0; i < 4; ++i) {
            sides[i] = to_number((*area)[i], "area", -1e9, 1e9);
            text += (i == 0 ? "" : ",") + plain_number_text(sides[i]);
        }
        if (!(sides[0] < sides[2] && sides[1] < sides[3]))
            refuse("'area' is empty", kArea);
        add("area", text);
        const json* given = member("resolution_m");
        const double edge_m = given == nullptr
                                  ? m_world.voxel_m
                                  : to_number(*given, "resolution_m", m_world.voxel_m, 100'000);
        add("resolution", plain_number_text(edge_m));
        const double unit = m_world.crs.empty() ? 1 : m_world.crs_units_per_voxel;
        const double cell = edge_m / m_world.voxel_m * unit;
        const double columns = std::ceil((sides[2] - sides[0]) / cell) + 1;
        const double rows = std::ceil((sides[3] - sides[1]) / cell) + 1;
        if (!(columns <= kMaxSide && rows <= kMaxSide &&
              columns * rows <= static_cast<double>(m_limits.max_cells)))
            refuse(plain_number_text(columns) + " x " + plain_number_text(rows) + " cells",
                   "up to " + std::to_string(m_limits.max_cells) +
                       " in all, by a smaller area or larger cells");
        m_out.cells = static_cast<std::int64_t>(columns * rows);
    }

    void read_time() {
        constexpr const char* kDay = "a day as YYYY-MM-DD";
        digits("date", "0000-00-00", kDay);
        digits("from", "0000-00-00", kDay);
        digits("to", "0000-00-00", kDay);
        number("step_min", "step-min", 1, 60, true);
        if (const json* zone = member("zone")) {
            if (!zone->is_string() || !is_zone(zone->get_ref<const std::string&>()))
                refuse("'zone' is " + shown(*zone), "a name like Europe/Ljubljana");
            add("zone", zone->get<std::string>());
        }
        if (m_out.kind != "sun")
            return;
        digits("at", "00:00", "a time as HH:MM");
        if (truth("monthly").value_or(false))
            m_out.words.emplace_back("--monthly");
    }

    void read_sight() {
        constexpr const char* kForm =
            "[[east, north, metres above the surface], ...] in the world's CRS, or voxels; 1 to 16";
        const json* observers = member("observers");
        if (observers == nullptr || !observers->is_array() || observers->empty() ||
            observers->size() > kMaxObservers)
            refuse("no 'observers', or not as many", kForm);
        for (const json& one : *observers) {
            if (!one.is_array() || one.size() != 3)
                refuse("one of the 'observers' is not three numbers", kForm);
            add("observer", plain_number_text(to_number(one[0], "observers", -1e9, 1e9)) + "," +
                                plain_number_text(to_number(one[1], "observers", -1e9, 1e9)) +
                                ",+" +
                                plain_number_text(to_number(one[2], "observers", 0, 10'000)));
        }
        number("target_m", "target-height", 0, 10'000);
    }

    const json m_in;
    const voxel::WorldInfo& m_world;
    const JobLimits& m_limits;
    std::set<std::string> m_known;
    const voxel::AnalysisTerms* m_terms = nullptr;  ///< of the kind
    JobRequest m_out;
};

}  // namespace

JobRequest read_job_request(std::string_view body, const voxel::WorldInfo& world,
                            const JobLimits& limits) {
    return RequestReader(body, world, limits).read();
}

}  // namespace terravox::jobs
