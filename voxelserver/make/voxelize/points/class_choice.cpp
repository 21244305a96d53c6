#include "voxelserver/make/voxelize/points/class_choice.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "common/util/error.hpp"
#include "common/util/log.hpp"
#include "voxelserver/make/voxelize/points/square_sample.hpp"

namespace terravox::voxelize {
namespace {

struct Choice {
    std::string table;
    std::string why;
};

/// The table of the sources whose names some of the files have, where these agree: the points of a
/// world are read by one table.
std::optional<Choice> choose_by_name(const std::vector<SquareSource>& files,
                                     const std::vector<std::optional<grid::NamedSquare>>& squares) {
    std::vector<std::size_t> named;
    for (std::size_t i = 0; i < files.size(); ++i)
        if (squares[i] && !squares[i]->class_table.empty())
            named.push_back(i);
    if (named.empty())
        return std::nullopt;
    const auto name = [&](std::size_t i) { return files[i].info.path.filename().string(); };
    const grid::NamedSquare& first = *squares[named.front()];
    const auto other = std::find_if(named.begin(), named.end(), [&](std::size_t i) {
        return squares[i]->class_table != first.class_table;
    });
    if (other != named.end()) {
        util::log_warn(
            "class table: {} is named as source {} names its squares (table {}), {} as source {} "
            "does (table {}); their names do not count; --classes names one",
            name(named.front()), first.source, first.class_table, name(*other),
            squares[*other]->source, squares[*other]->class_table);
        return std::nullopt;
    }
    std::string why = fmt::format("{} is named as source {} names its squares", name(named.front()),
                                  first.source);
    if (named.size() < files.size())
        why += fmt::format(", and the names of {} of {} files say nothing",
                           files.size() - named.size(), files.size());
    return Choice{first.class_table, why};
}

/// @param values at least one
double find_median(std::vector<double> values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

/// A header may state bounds that are wrong on one side (extent.hpp), and then its middle is as
/// well: so half of the points decide where it is outside.
bool lies_in(const SquareSource& file, const std::array<double, 4>& extent) {
    const auto holds = [&](double x, double y) {
        return x >= extent[0] && x <= extent[2] && y >= extent[1] && y <= extent[3];
    };
    const pointcloud::PointCloudInfo& info = file.info;
    if (extent == std::array<double, 4>{} ||
        holds((info.min[0] + info.max[0]) / 2, (info.min[1] + info.max[1]) / 2))
        return true;
    std::vector<double> x;
    std::vector<double> y;
    for (const pointcloud::Point& p : file.points->sample(kSampledPoints)) {
        x.push_back(p.x);
        y.push_back(p.y);
    }
    return !x.empty() && holds(find_median(std::move(x)), find_median(std::move(y)));
}

/// The classes of some files, looked for once, when a table asks for them.
class FoundClasses {
public:
    explicit FoundClasses(const std::vector<SquareSource>& files) : m_files(files) {}

    const std::bitset<256>& find() {
        constexpr std::size_t kMostFiles = 8;
        const std::size_t count = std::min(kMostFiles, m_files.size());
        for (std::size_t i = 0; i < count && !m_is_taken; ++i)
            look_over(*m_files[i * m_files.size() / count].points,
                      [&](std::span<const pointcloud::Point> batch) {
                          for (const pointcloud::Point& p : batch)
                              m_classes.set(p.classification);
                      });
        m_is_taken = true;
        return m_classes;
    }

private:
    const std::vector<SquareSource>& m_files;
    std::bitset<256> m_classes;
    bool m_is_taken = false;
};

std::string list_codes(const std::bitset<256>& codes) {
    std::string out;
    for (std::size_t c = 0; c < codes.size(); ++c)
        if (codes[c])
            out += (out.empty() ? "" : ", ") + std::to_string(c);
    return out;
}

/// A table that somebody has added may name a system that is none: it is meant for no file then.
bool is_in(const geo::Crs& crs, const std::string& text) {
    try {
        return crs.name() == text || crs.same_horizontal(geo::Crs::from_text(text));
    } catch (const util::UsageError& e) {
        util::log_warn("[meant] of a class table: {}", e.what());
        return false;
    }
}

/// Why a table is meant for the files; nullopt: it is not.
std::optional<std::string> why_meant(const Meant& meant, const std::vector<SquareSource>& files,
                                     FoundClasses& classes) {
    const geo::Crs& crs = *files.front().info.crs;
    const auto system = std::find_if(meant.crs.begin(), meant.crs.end(),
                                     [&](const std::string& text) { return is_in(crs, text); });
    if (system == meant.crs.end() ||
        !std::all_of(files.begin(), files.end(), [&](const SquareSource& file) {
            return lies_in(file, meant.extent) && file.info.crs->same_horizontal(crs);
        }))
        return std::nullopt;
    std::string why = "the files are in " + *system;
    if (meant.with) {
        const std::bitset<256> found = classes.find() & *meant.with;
        if (found.none())
            return std::nullopt;
        why += ", and have points of class " + list_codes(found);
    }
    if (meant.without) {
        if ((classes.find() & *meant.without).any())
            return std::nullopt;
        why += ", none of class " + list_codes(*meant.without);
    }
    return why;
}

Choice choose(const std::vector<SquareSource>& files,
              const std::vector<std::optional<grid::NamedSquare>>& squares) {
    if (auto named = choose_by_name(files, squares))
        return *std::move(named);
    FoundClasses classes(files);
    for (const ClassTable& table : shipped_class_tables())
        if (const auto why = why_meant(table.meant, files, classes))
            return {table.id, *why};
    return {"asprs", ""};
}

}  // namespace

ClassTable choose_class_table(const LidarWorldOptions& options,
                              const std::vector<SquareSource>& files,
                              const std::vector<std::optional<grid::NamedSquare>>& squares) {
    const Unnamed unnamed = options.mark_unknown ? Unnamed::kMarked : Unnamed::kGuessed;
    if (options.classes != kAnyClassTable)
        return load_class_table(options.classes, unnamed);
    const Choice choice = choose(files, squares);
    ClassTable out = load_class_table(choice.table, unnamed);
    if (!choice.why.empty())
        util::log_info("class table {} ({}): {}; --classes chooses", out.id, out.title, choice.why);
    return out;
}

}  // namespace terravox::voxelize
