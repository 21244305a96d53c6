#include "raytracer/analyse/horizon/skyline.hpp"

#include <cmath>
#include <iterator>

namespace terravox::analyse {

double Skyline::lift(const Place& before, const Place& at, const Place& after) {
    const double share =
        (at.distance_m - before.distance_m) / (after.distance_m - before.distance_m);
    return at.height_m - (before.height_m + (after.height_m - before.height_m) * share);
}

double Skyline::highest_m() const noexcept {
    return m_places.empty() ? -HUGE_VAL : m_places.back().height_m;
}

void Skyline::add(double distance_m, double height_m) {
    // What is farther away and no higher hides nothing more.
    if (height_m <= highest_m())
        return;
    const Place added{distance_m, height_m};
    while (m_places.size() >= 2 && lift(m_places[m_places.size() - 2], m_places.back(), added) <= 0)
        m_places.pop_back();
    m_places.push_back(added);
}

solar::FarHorizon::Tops Skyline::tops() const {
    constexpr double kLeast_m = 0.5;
    std::vector<Place> places = m_places;
    while (places.size() > 2) {
        std::size_t least = 0;
        double least_m = HUGE_VAL;
        for (std::size_t i = 1; i + 1 < places.size(); ++i) {
            const double lifted_m = lift(places[i - 1], places[i], places[i + 1]);
            if (lifted_m < least_m) {
                least = i;
                least_m = lifted_m;
            }
        }
        if (places.size() <= solar::FarHorizon::kMaxTops && least_m >= kLeast_m)
            break;
        places.erase(std::next(places.begin(), static_cast<std::ptrdiff_t>(least)));
    }
    solar::FarHorizon::Tops out;
    for (const Place& place : places) {
        const solar::FarTop top{static_cast<std::int32_t>(std::lround(place.distance_m)),
                                static_cast<std::int32_t>(std::lround(place.height_m))};
        const bool is_next = out.empty() || (top.distance_m > out.back().distance_m &&
                                             top.height_m > out.back().height_m);
        if (is_next)
            out.push_back(top);
    }
    return out;
}

}  // namespace terravox::analyse
