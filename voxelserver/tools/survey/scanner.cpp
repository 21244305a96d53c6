#include "voxelserver/tools/survey/scanner.hpp"

namespace terravox::survey {

template <class Visit>
void ObstacleGrid::for_each_cell(const Box2& box, const Visit& visit) const {
    const auto clamped = [](double v, std::size_t count) {
        return static_cast<std::size_t>(std::clamp(v, 0.0, static_cast<double>(count - 1)));
    };
    if (!box.overlaps(m_area))
        return;
    const auto c0 = clamped((box.x0 - m_area.x0) * kPerCell, m_columns);
    const auto c1 = clamped((box.x1 - m_area.x0) * kPerCell, m_columns);
    const auto r0 = clamped((box.y0 - m_area.y0) * kPerCell, m_rows);
    const auto r1 = clamped((box.y1 - m_area.y0) * kPerCell, m_rows);
    for (auto row = r0; row <= r1; ++row)
        for (auto column = c0; column <= c1; ++column)
            visit(row * m_columns + column);
}

// Calls visit(obstacle, box of feet): the outline, widened by how far a pulse leans between the
// ground and the top. The ground under a pulse's foot may lie lower than at the obstacle, so 8 m
// are added to each height.
template <class Visit>
void ObstacleGrid::for_each_obstacle(const SquareModel& model, const Visit& visit) const {
    const auto widened = [](const Box2& box, double height_m) {
        return box.expanded((height_m + 8.0) * ScanPattern::kMaxLean);
    };
    const auto around = [](Vec2 p, double r) { return Box2{p.x - r, p.y - r, p.x + r, p.y + r}; };
    std::uint32_t i = 0;
    for (const Building& b : model.buildings())
        visit({ObstacleKind::kBuilding, i++}, widened(b.bounds(), b.top_of_all_m() - b.ground_m));
    i = 0;
    for (const Bridge& b : model.roads().bridges)
        visit({ObstacleKind::kBridge, i++}, widened(b.bounds(), b.deck_m - b.water_m));
    i = 0;
    for (const Tree& t : model.trees())
        visit({ObstacleKind::kTree, i++}, widened(around(t.at, t.radius_m), t.height_m - 6.0));
    i = 0;
    for (const Pylon& p : model.power_line().pylons)
        visit({ObstacleKind::kPylon, i++}, widened(around(p.at, kPylonArm_m), kPylonHeight_m));
    i = 0;
    for (const Wire& w : model.power_line().wires) {
        // In pieces: the box around a whole span would be far too wide.
        for (int piece = 0; piece < 16; ++piece) {
            const Vec2 a = w.a + (w.b - w.a) * (piece / 16.0);
            const Vec2 b = w.a + (w.b - w.a) * ((piece + 1) / 16.0);
            visit({ObstacleKind::kWire, i}, widened({std::min(a.x, b.x), std::min(a.y, b.y),
                                                     std::max(a.x, b.x), std::max(a.y, b.y)},
                                                    kPylonHeight_m));
        }
        ++i;
    }
}

ObstacleGrid::ObstacleGrid(const SquareModel& model)
    : m_area(model.extent().box().expanded(kObstacleMargin_m)) {
    m_columns = static_cast<std::size_t>((m_area.x1 - m_area.x0) * kPerCell) + 1;
    m_rows = static_cast<std::size_t>((m_area.y1 - m_area.y0) * kPerCell) + 1;
    // Two passes: count, then place. A wire found twice in one cell is listed once.
    m_starts.assign(m_columns * m_rows + 1, 0);
    std::vector<std::uint32_t> last_wire(m_columns * m_rows, ~0U);
    const auto repeated = [&](Obstacle o, std::size_t cell) {
        if (o.kind != ObstacleKind::kWire)
            return false;
        const bool same = last_wire[cell] == o.index;
        last_wire[cell] = o.index;
        return same;
    };
    for_each_obstacle(model, [&](Obstacle o, const Box2& box) {
        for_each_cell(box, [&](std::size_t cell) {
            if (!repeated(o, cell))
                ++m_starts[cell + 1];
        });
    });
    for (std::size_t i = 1; i < m_starts.size(); ++i)
        m_starts[i] += m_starts[i - 1];
    m_items.resize(m_starts.back());
    auto next = m_starts;
    last_wire.assign(last_wire.size(), ~0U);
    for_each_obstacle(model, [&](Obstacle o, const Box2& box) {
        for_each_cell(box, [&](std::size_t cell) {
            if (!repeated(o, cell))
                m_items[next[cell]++] = o;
        });
    });
}

namespace {

constexpr double kRangeNoise_m = 0.025;  ///< standard deviation of a measured height
constexpr double kDropout = 0.004;       ///< pulses without any echo
constexpr double kNoiseShare =
    2.0e-5;  ///< pulses that hit a bird, and that give a multipath echo, each
constexpr double kWallShare = 0.55;  ///< pulses that return from a wall
constexpr double kWireHit_m = 0.14;  ///< half the width of the beam plus the wire
constexpr int kMaxCrowns = 4;

std::uint8_t vegetation_class(double above_m) noexcept {
    return above_m < kMediumFrom_m ? las_class::kLowVegetation
           : above_m < kHighFrom_m ? las_class::kMediumVegetation
                                   : las_class::kHighVegetation;
}

// Reflectivity at 1064 nm, roughly: grass and leaves bright, asphalt and water dark.
double brightness(Cover cover) noexcept {
    switch (cover) {
        case Cover::kRoad: return 9000;
        case Cover::kGravelRoad:
        case Cover::kBeach:
        case Cover::kCourtyard: return 24000;
        case Cover::kRock: return 20000;
        case Cover::kPloughed: return 15000;
        case Cover::kForest: return 22000;
        default: return 34000;
    }
}

// Roofs at the same wavelength: clay tiles bright, slate and sheet metal dark.
double brightness(RoofColour colour) noexcept {
    switch (colour) {
        case RoofColour::kRed: return 28000;
        case RoofColour::kGrey: return 11000;
        case RoofColour::kPale: return 25000;
        case RoofColour::kCopper: return 15000;
    }
    return 21000;
}

constexpr double kWallBrightness = 21000;

// Receivers are set anew for every flight line.
double to_gain(std::uint16_t strip) noexcept {
    constexpr double kLeast = 0.7;
    constexpr double kGreatest = 1.3;
    Random random(0x6A14ULL ^ strip);
    return random.range(kLeast, kGreatest);
}

// What stands on open land, metres, and how often a pulse meets it: grass, crops.
struct Growth {
    double share;
    double from_m;
    double to_m;
};
Growth find_growth(Cover cover) noexcept {
    switch (cover) {
        case Cover::kMaize: return {0.55, 1.4, 2.3};
        case Cover::kWheat:
        case Cover::kBarley: return {0.30, 0.5, 0.9};
        case Cover::kRape: return {0.40, 0.8, 1.3};
        case Cover::kMeadow: return {0.05, 0.2, 0.6};
        case Cover::kGarden: return {0.06, 0.2, 1.0};
        case Cover::kForest:
        case Cover::kScrub: return {0.14, 0.3, 2.2};
        default: return {0, 0, 0};
    }
}

// Insertion sort: at most six items, without allocation.
template <class Item>
void sort_highest_first(Item* items, int count) noexcept {
    for (int i = 1; i < count; ++i) {
        const Item item = items[i];
        int at = i;
        for (; at > 0 && items[at - 1].height_m < item.height_m; --at)
            items[at] = items[at - 1];
        items[at] = item;
    }
}

}  // namespace

/// One pulse on its way: what it has hit so far.
struct Scanner::Shot {
    Ray ray;
    std::uint64_t key;
    Random random;
    Solid solid{-1e9, 0, false};  ///< the highest solid object, where the pulse ends
    struct Crown {
        double height_m;
        const Tree* tree;
    };
    std::array<Crown, kMaxCrowns> crowns;
    int crown_count = 0;
    double energy = 1;
    double gain = 1;
    Returns out;

    void add(double height_m, std::uint8_t classification, double intensity) noexcept {
        if (out.count == Returns::kMax)
            return;
        const double measured = height_m + kRangeNoise_m * random.normal();
        const double shade =
            std::clamp(intensity * gain * energy * random.range(0.8, 1.2), 200.0, 65000.0);
        out.points[static_cast<std::size_t>(out.count++)] = {
            ray.at(measured), measured, static_cast<std::uint16_t>(shade), classification, 1, 1};
    }
};

std::optional<Scanner::Solid> Scanner::hit(const Ray& ray, const Building& b) noexcept {
    // Where the pulse is over the footprint, as a range of heights.
    double low = std::max(b.ground_m - 3.0, b.underside_m);
    double high = b.top_of_all_m() + 0.01;
    const Vec2 from = ray.at(0) - b.centre;
    const Vec2 right = turn_left(b.direction);
    const std::array<std::array<double, 3>, 2> slabs = {
        {{dot(from, b.direction), dot(ray.lean, b.direction), b.half_length_m},
         {dot(from, right), dot(ray.lean, right), b.half_width_m}}};
    for (const auto& [start, step, half] : slabs) {
        if (std::abs(step) < 1e-12) {
            if (std::abs(start) > half)
                return std::nullopt;
            continue;
        }
        const double z0 = (-half - start) / step;
        const double z1 = (half - start) / step;
        low = std::max(low, std::min(z0, z1));
        high = std::min(high, std::max(z0, z1));
    }
    if (low >= high)
        return std::nullopt;
    const auto inside = [&](double z) {
        const auto top = b.top_m(ray.at(z));
        return top && z <= *top;
    };
    const auto building = [&](double height, bool wall) {
        return Solid{height, las_class::kBuilding, wall,
                     wall ? kWallBrightness : brightness(b.colour)};
    };
    // Down from the entry: in steps to the first point inside, then by halving.
    constexpr int kSteps = 10;
    constexpr int kHalvings = 10;
    double above = high - 1e-7 * (high - low);
    if (inside(above))
        return building(above, above < b.eaves_m - 0.05);
    for (int i = 1; i <= kSteps; ++i) {
        double below = lerp(high, low, (i - 1e-7) / kSteps);
        if (!inside(below)) {
            above = below;
            continue;
        }
        for (int k = 0; k < kHalvings; ++k) {
            const double middle = 0.5 * (above + below);
            (inside(middle) ? below : above) = middle;
        }
        const bool round_wall = b.roof == RoofType::kCone && below < b.eaves_m - 0.05;
        return building(below, round_wall);
    }
    return std::nullopt;
}

std::optional<Scanner::Solid> Scanner::hit(const Ray& ray, const Bridge& bridge) noexcept {
    const double parapet = bridge.deck_m + kParapet_m;
    if (bridge.top_m(ray.at(parapet)) == parapet)
        return Solid{parapet, las_class::kBridge, false};
    if (bridge.top_m(ray.at(bridge.deck_m)) == bridge.deck_m)
        return Solid{bridge.deck_m, las_class::kBridge, false};
    return std::nullopt;
}

std::optional<double> Scanner::hit(const Ray& ray, const Wire& wire) noexcept {
    // The wire hangs in a vertical plane: two rounds find the height at which the pulse crosses it.
    double height = 0.5 * (wire.a_m + wire.b_m) - 0.5 * wire.sag_m;
    OnSegment on;
    for (int round = 0; round < 2; ++round) {
        on = nearest_on_segment(ray.at(height), wire.a, wire.b);
        height = wire.height_m(on.along);
    }
    on = nearest_on_segment(ray.at(height), wire.a, wire.b);
    if (on.distance_m > kWireHit_m)
        return std::nullopt;
    return height;
}

std::optional<double> Scanner::enter(const Ray& ray, const Tree& tree) noexcept {
    // Quick rejection at the middle of the crown.
    const double middle = tree.ground_m + 0.5 * (tree.height_m + tree.crown_base_m);
    const Vec2 off = ray.at(middle) - tree.at;
    const double reach =
        tree.radius_m + 0.5 * (tree.height_m - tree.crown_base_m) * ScanPattern::kMaxLean;
    if (dot(off, off) > reach * reach)
        return std::nullopt;
    double height = middle;
    for (int round = 0; round < 3; ++round) {
        const auto top = tree.crown_top_m(length(ray.at(height) - tree.at));
        if (!top)
            return std::nullopt;
        height = *top;
    }
    return height;
}

void Scanner::meet(Shot& shot, const Obstacle& obstacle) const noexcept {
    const auto solid = [&](const std::optional<Solid>& met) {
        if (met && met->height_m > shot.solid.height_m)
            shot.solid = *met;
    };
    switch (obstacle.kind) {
        case ObstacleKind::kBuilding:
            solid(hit(shot.ray, m_model.buildings()[obstacle.index]));
            break;
        case ObstacleKind::kBridge:
            solid(hit(shot.ray, m_model.roads().bridges[obstacle.index]));
            break;
        case ObstacleKind::kTree: {
            const Tree& tree = m_model.trees()[obstacle.index];
            const auto height = enter(shot.ray, tree);
            if (height && shot.crown_count < kMaxCrowns)
                shot.crowns[static_cast<std::size_t>(shot.crown_count++)] = {*height, &tree};
            break;
        }
        case ObstacleKind::kPylon: {
            // A lattice: a random height is tried, and most of the light passes. The pulse's own
            // random numbers must not be drawn for an obstacle that it only might hit: that depends
            // on the grid of the square.
            const Pylon& pylon = m_model.power_line().pylons[obstacle.index];
            Random random(shot.key ^ 0x9E10);
            const double height = random.range(pylon.ground_m, pylon.top_m);
            if (pylon.holds(shot.ray.at(height), height) && random.chance(0.6))
                solid(Solid{height, las_class::kTower, false});
            break;
        }
        case ObstacleKind::kWire: {
            const auto height = hit(shot.ray, m_model.power_line().wires[obstacle.index]);
            if (height && shot.random.chance(0.75))
                shot.add(*height, las_class::kWire, 5000);
            break;
        }
    }
}

// Leaves return part of the light at the top of each crown and inside; the rest continues to the
// ground.
void Scanner::pass_crowns(Shot& shot) const noexcept {
    sort_highest_first(shot.crowns.data(), shot.crown_count);
    const auto end = shot.crowns.begin() + shot.crown_count;
    for (auto crown = shot.crowns.begin(); crown != end && shot.energy > 0.12; ++crown) {
        const Tree& tree = *crown->tree;
        const double top = crown->height_m;
        const double bottom =
            std::max(tree.crown_bottom_m(length(shot.ray.at(top) - tree.at)), tree.ground_m + 0.1);
        const double depth = std::max(0.0, top - bottom);
        if (top <= shot.solid.height_m || shot.random.chance(0.10))
            continue;
        const double met =
            top - std::min(0.5 * depth, 0.9 * shot.random.unit() * shot.random.unit());
        shot.add(met, vegetation_class(met - tree.ground_m), 26000);
        shot.energy *= shot.random.range(0.30, 0.75);
        const double inner = met - depth * shot.random.range(0.25, 0.95);
        if (depth > 2.5 && inner > shot.solid.height_m && shot.random.chance(0.45 * shot.energy)) {
            shot.add(inner, vegetation_class(inner - tree.ground_m), 18000);
            shot.energy *= 0.6;
        }
    }
}

void Scanner::reach_ground(Shot& shot) const noexcept {
    const Cover cover = m_model.cover(shot.ray.foot);
    const auto water = m_model.water_m(shot.ray.foot);
    if (water) {
        // A mirror: an echo comes back straight from below, or from shallow water near the bank.
        const double off_nadir = length(shot.ray.lean);
        const double depth = *water - shot.ray.foot_m;
        const double share = off_nadir < 0.06 ? 0.45 * (1.0 - off_nadir / 0.06) : 0.0;
        if (shot.random.chance(std::max(share, depth < 0.5 ? 0.10 : 0.004)) && shot.energy > 0.3)
            shot.add(*water, las_class::kWater, 7000);
        return;
    }
    const Growth growth = find_growth(cover);
    if (growth.share > 0 && shot.crown_count == 0 && shot.random.chance(growth.share)) {
        const double height = shot.random.range(growth.from_m, growth.to_m);
        shot.add(shot.ray.foot_m + height, las_class::kLowVegetation, 30000);
        if (height < 1.2 || shot.random.chance(0.5))
            return;  // too near to the ground for a second echo
        shot.energy *= 0.5;
    }
    if (shot.out.count == 0 || shot.random.chance(0.25 + 0.9 * shot.energy))
        shot.add(shot.ray.foot_m, las_class::kGround, brightness(cover));
}

Returns Scanner::shoot(const Pulse& pulse) const noexcept {
    Shot shot{{pulse.foot, pulse.lean, m_model.ground_m(pulse.foot)},
              pulse.key,
              Random(pulse.key ^ 0x5EC0),
              {-1e9, 0, false},
              {},
              0,
              1,
              to_gain(pulse.strip),
              {}};
    const double dice = shot.random.unit();
    if (dice < kDropout)
        return shot.out;
    if (dice < kDropout + kNoiseShare)
        shot.add(shot.ray.foot_m - shot.random.range(3, 30), las_class::kLowNoise, 800);
    else if (dice < kDropout + 2 * kNoiseShare)
        shot.add(shot.ray.foot_m + shot.random.range(45, 160), las_class::kHighNoise, 900);
    else {
        for (const Obstacle& obstacle : m_obstacles.at(pulse.foot))
            meet(shot, obstacle);
        pass_crowns(shot);
        if (shot.solid.classification == 0)
            reach_ground(shot);
        else if (!shot.solid.wall || shot.random.chance(kWallShare))
            shot.add(shot.solid.height_m, shot.solid.classification, shot.solid.intensity);
    }
    sort_highest_first(shot.out.points.data(), shot.out.count);
    for (int i = 0; i < shot.out.count; ++i) {
        auto& point = shot.out.points[static_cast<std::size_t>(i)];
        point.return_number = static_cast<std::uint8_t>(i + 1);
        point.number_of_returns = static_cast<std::uint8_t>(shot.out.count);
    }
    return shot.out;
}

}  // namespace terravox::survey
