#include "raytracer/commands/analyse/observer_arguments.hpp"

#include <string_view>

#include "common/util/error.hpp"
#include "raytracer/commands/number_list.hpp"

namespace terravox::commands {
namespace {

constexpr std::string_view kAboveGround = ",above-ground";

}  // namespace

analyse::Observer observer_of(const std::string& text, const voxel::WorldInfo& world) {
    analyse::Observer out;
    out.text = text;
    std::string numbers = text;
    const std::size_t height = numbers.rfind(',') + 1;
    if (numbers.ends_with(kAboveGround)) {
        out.base = analyse::HeightBase::kGround;
        numbers.resize(numbers.size() - kAboveGround.size());
    } else if (height < numbers.size() && numbers[height] == '+') {
        out.base = analyse::HeightBase::kTop;
        numbers.erase(height, 1);
    }
    const auto values = numbers_of("analyse sight", "--observer", numbers, 3, kObserverForms);
    if (values.size() != 3)
        throw util::UsageError("analyse sight: --observer ''; allowed: " +
                               std::string(kObserverForms));
    const bool is_placed = !world.crs.empty();
    const double unit = is_placed ? world.crs_units_per_voxel : 1;
    out.x = values[0] / unit;
    out.z = is_placed ? -values[1] / unit : values[1];
    out.height_m = values[2];
    return out;
}

std::vector<analyse::Observer> observers_of(const std::vector<std::string>& texts,
                                            const voxel::WorldInfo& world) {
    if (texts.empty() || texts.size() > scene::PointList::kMaxPoints)
        throw util::UsageError("analyse sight: " + std::to_string(texts.size()) +
                               " observers; allowed: 1 to " +
                               std::to_string(scene::PointList::kMaxPoints) + ", by --observer");
    std::vector<analyse::Observer> out;
    for (const std::string& text : texts)
        out.push_back(observer_of(text, world));
    return out;
}

}  // namespace terravox::commands
