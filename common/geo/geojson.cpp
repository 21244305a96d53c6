#include "common/geo/geojson.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <span>
#include <string_view>

#include "common/util/error.hpp"
#include "common/util/files.hpp"
#include "common/util/json_text.hpp"
#include "common/util/log.hpp"
#include "common/util/numbers.hpp"
#include "common/util/text.hpp"

namespace terravox::geo {
namespace {

using nlohmann::json;

constexpr double kFoot_m = 0.3048;
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// Takes the number that a text begins with off it, and spaces around it.
/// @return NaN where it begins with none
double take_number(std::string_view& text) {
    text = util::trimmed(text);
    (void)util::take(text, '+');
    const double number = util::take_number<double>(text).value_or(kNone);
    text = util::trimmed(text);
    return std::isfinite(number) ? number : kNone;
}

/// @return the length that a text says, in metres; NaN for others
double length_in(std::string_view text) {
    const double number = take_number(text);
    struct Unit {
        std::string_view name;
        double metres;
    };
    static constexpr std::array<Unit, 11> kUnits{{{"", 1},
                                                  {"m", 1},
                                                  {"metre", 1},
                                                  {"metres", 1},
                                                  {"meter", 1},
                                                  {"meters", 1},
                                                  {"cm", 0.01},
                                                  {"ft", kFoot_m},
                                                  {"foot", kFoot_m},
                                                  {"feet", kFoot_m},
                                                  {"'", kFoot_m}}};
    for (const Unit& unit : kUnits)
        if (text == unit.name)
            return number * unit.metres;
    // Feet and inches.
    if (!text.starts_with('\''))
        return kNone;
    text.remove_prefix(1);
    const double inches = take_number(text);
    return text == "\"" || text == "''" ? (number + inches / 12) * kFoot_m : kNone;
}

/// What is wrong with one feature.
class FeatureError : public util::Error {
public:
    using Error::Error;
};

/// Reads one file.
class Reader {
public:
    Reader(const std::filesystem::path& file, const std::stop_token& stop)
        : m_attempt("read the GeoJSON file " + file.string()), m_stop(stop) {
        const std::string text = util::read_text(file, kMaxGeoJson_bytes, m_attempt);
        check_stop();
        if (util::has_more_json_levels(text, util::kMaxJsonLevels))
            fail("more than " + std::to_string(util::kMaxJsonLevels) + " lists in lists");
        m_root = util::parse_json(text);
        if (m_root.is_discarded())
            m_root = read_lines(text);
        if (m_root.is_discarded())
            fail("it is no JSON from byte " + std::to_string(first_wrong_byte(text)) +
                 " on; allowed: UTF-8");
        if (!m_root.is_object())
            fail("it is no JSON object");
    }

    [[nodiscard]] std::vector<Shape> shapes(const Crs& to) {
        read_root();
        transform(to);
        if (!m_fault.empty() && m_shapes.empty())
            throw util::Error(m_fault);
        if (!m_fault.empty())
            util::log_warn("{}; it is left out{}", m_fault,
                           m_faults > 1 ? ", one of " + std::to_string(m_faults) + " such" : "");
        return std::move(m_shapes);
    }

private:
    /// A text with a feature on each line, which may begin with a record separator.
    /// Ref: Gillies, "GeoJSON Text Sequences", RFC 8142, 2017.
    /// @return a collection of them; discarded where the first line is no feature
    [[nodiscard]] json read_lines(std::string_view text) const {
        json features = json::array();
        while (!text.empty()) {
            const std::size_t end = std::min(text.find('\n'), text.size());
            std::string_view line = util::trimmed(text.substr(0, end));
            text.remove_prefix(std::min(end + 1, text.size()));
            (void)util::take(line, '\x1e');
            if (line.empty())
                continue;
            json one = util::parse_json(line);
            if (features.empty() && (!one.is_object() || one.value("type", json()) != "Feature"))
                return json::value_t::discarded;
            if (one.is_discarded())
                fail("line " + std::to_string(features.size() + 1) +
                     " of those with a feature each is no JSON");
            features.push_back(std::move(one));
        }
        if (features.empty())
            return json::value_t::discarded;
        return {{"type", "FeatureCollection"}, {"features", std::move(features)}};
    }
    [[nodiscard]] static std::size_t first_wrong_byte(const std::string& text) {
        try {
            (void)json::parse(text);
        } catch (const json::parse_error& e) {
            return e.byte;
        }
        return 0;
    }
    [[noreturn]] void fail(const std::string& what) const {
        throw util::Error(m_attempt + ": " + what);
    }
    [[noreturn]] void fail_feature(const std::string& what) const {
        throw FeatureError(m_attempt + ": feature " + std::to_string(m_feature) + " " + what);
    }
    /// Leaves the feature out that is being read. @param before shapes without it
    void leave_out(const FeatureError& fault, std::size_t before) {
        m_shapes.resize(before);
        if (m_faults++ == 0)
            m_fault = fault.what();
    }
    void check_stop() const {
        if (m_stop.stop_requested())
            fail("interrupted");
    }
    [[nodiscard]] std::string find_type(const json& object) const {
        const auto type = object.is_object() ? object.find("type") : object.end();
        if (!object.is_object() || type == object.end() || !type->is_string())
            fail_feature("has an object without a type");
        return type->get<std::string>();
    }
    [[nodiscard]] const json& member(const json& object, const char* name) const {
        const auto found = object.find(name);
        if (found == object.end() || !found->is_array())
            fail_feature(std::string("has no list '") + name + "'");
        return *found;
    }

    void read_root() {
        const std::string type = find_type(m_root);
        if (type != "FeatureCollection") {
            read_feature(m_root, type == "Feature");
            return;
        }
        for (const json& feature : member(m_root, "features")) {
            const std::size_t before = m_shapes.size();
            try {
                if (find_type(feature) != "Feature")
                    fail_feature("is a " + find_type(feature));
                read_feature(feature, true);
            } catch (const FeatureError& fault) {
                leave_out(fault, before);
            }
            ++m_feature;
        }
    }

    void read_feature(const json& object, bool is_feature) {
        check_stop();
        m_lengths = std::make_shared<Lengths>();
        m_lengths->attempt = m_attempt + ": feature " + std::to_string(m_feature);
        if (!is_feature) {
            read_geometry(object);
            return;
        }
        if (const auto found = object.find("properties");
            found != object.end() && found->is_object())
            for (const auto& [name, value] : found->items())
                read_property(name, value);
        // A feature without a place has the geometry null.
        if (const auto found = object.find("geometry"); found != object.end() && found->is_object())
            read_geometry(*found);
    }

    void read_property(const std::string& name, const json& value) {
        double metres = kNone;
        if (value.is_number())
            metres = value.get<double>();
        else if (value.is_string())
            metres = length_in(value.get_ref<const std::string&>());
        constexpr std::size_t kShown = 40;
        if (!std::isnan(metres))
            m_lengths->metres[name] = metres;
        else if (!value.is_null() && value != "" && !value.is_structured())
            m_lengths->others[name] =
                value.dump(-1, ' ', false, json::error_handler_t::replace).substr(0, kShown);
    }

    void read_geometry(const json& geometry) {
        const std::string type = find_type(geometry);
        if (type == "GeometryCollection") {
            for (const json& part : member(geometry, "geometries"))
                read_geometry(part);
            return;
        }
        constexpr std::array<std::string_view, 6> kTypes{
            "Point", "LineString", "Polygon", "MultiPoint", "MultiLineString", "MultiPolygon"};
        if (std::find(kTypes.begin(), kTypes.end(), type) == kTypes.end())
            fail_feature("is a " + type + "; allowed: points, lines, polygons");
        const json& at = member(geometry, "coordinates");
        if (at.empty())
            return;
        if (type == "Point")
            add(ShapeKind::kPoint, json::array({json::array({at})}));
        else if (type == "LineString")
            add(ShapeKind::kLine, json::array({at}));
        else if (type == "Polygon")
            add(ShapeKind::kPolygon, at);
        else
            read_parts(type, at);
    }

    void read_parts(const std::string& type, const json& parts) {
        for (const json& part : parts) {
            if (type == "MultiPoint")
                add(ShapeKind::kPoint, json::array({json::array({part})}));
            else if (type == "MultiLineString")
                add(ShapeKind::kLine, json::array({part}));
            else
                add(ShapeKind::kPolygon, part);
        }
    }

    void add(ShapeKind kind, const json& parts) {
        Shape shape;
        shape.kind = kind;
        shape.lengths = m_lengths;
        shape.feature = m_feature;
        if (!parts.is_array() || parts.empty())
            fail_feature("has no positions");
        for (const json& part : parts) {
            if (!part.is_array() || part.empty())
                fail_feature("has no positions");
            auto& positions = shape.parts.emplace_back();
            for (const json& position : part)
                positions.push_back(read_position(position));
        }
        m_shapes.push_back(std::move(shape));
    }

    [[nodiscard]] Shape::Position read_position(const json& from) {
        check_stop();
        if (++m_positions > kMaxGeoJsonPositions)
            fail("more than " + std::to_string(kMaxGeoJsonPositions) + " positions");
        Shape::Position out{0, 0, std::numeric_limits<double>::quiet_NaN()};
        if (!from.is_array() || from.size() < 2)
            fail_feature("has a position that is no list of numbers");
        for (std::size_t i = 0; i < std::min<std::size_t>(from.size(), 3); ++i) {
            if (!from[i].is_number())
                fail_feature("has a position that is no list of numbers");
            out[i] = from[i].get<double>();
        }
        return out;
    }

    /// @return nullptr where there is none
    static const json* find_in(const json& of, const char* name) {
        if (!of.is_object())
            return nullptr;
        const auto found = of.find(name);
        return found == of.end() ? nullptr : &*found;
    }

    /// The name of the file's CRS; empty: longitude and latitude.
    [[nodiscard]] std::string crs_name() const {
        const auto crs = m_root.find("crs");
        if (crs == m_root.end() || crs->is_null())
            return {};
        const json* name = find_in(*crs, "properties");
        name = name == nullptr ? nullptr : find_in(*name, "name");
        if (name == nullptr || !name->is_string())
            fail("a member 'crs' without a name");
        std::string text = name->get<std::string>();
        // The same as an address: .../AUTHORITY/VERSION/CODE.
        for (const std::string_view address :
             {"http://www.opengis.net/def/crs/", "https://www.opengis.net/def/crs/"})
            if (text.starts_with(address)) {
                text.erase(0, address.size());
                std::replace(text.begin(), text.end(), '/', ':');
                text.insert(0, "urn:ogc:def:crs:");
            }
        constexpr std::string_view kUrn = "urn:ogc:def:crs:";
        if (!text.starts_with(kUrn))
            return text;
        // AUTHORITY:VERSION:CODE, where the version may be empty.
        text.erase(0, kUrn.size());
        if (text.find(':') == std::string::npos)
            fail("a crs named " + std::string(kUrn) + text +
                 "; allowed: urn:ogc:def:crs:AUTHORITY:VERSION:CODE");
        return text.substr(0, text.find(':')) + text.substr(text.rfind(':'));
    }

    [[nodiscard]] Crs read_crs(const std::string& name) const {
        try {
            return Crs::from_text(name);
        } catch (const ProjUnusableError&) {
            throw;
        } catch (const util::Error& e) {
            fail(e.what());
        }
    }

    void transform(const Crs& to) {
        check_stop();
        const std::string name = crs_name();
        const Crs from = read_crs(name.empty() ? "OGC:CRS84" : name);
        if (from.same_horizontal(to))
            return;
        const Transform transform(from, to);
        try {
            move(transform, m_shapes);
        } catch (const util::Error&) {
            move_each(transform);
        }
    }
    static void move(const Transform& transform, std::span<Shape> shapes) {
        std::vector<double> x;
        std::vector<double> y;
        each(shapes, [&](Shape::Position& p) {
            x.push_back(p[0]);
            y.push_back(p[1]);
        });
        transform.apply(x, y);
        std::size_t i = 0;
        each(shapes, [&](Shape::Position& p) {
            p[0] = x[i];
            p[1] = y[i++];
        });
    }
    /// Leaves out features that lie outside of the domain of the transformation.
    void move_each(const Transform& transform) {
        std::vector<Shape> all = std::move(m_shapes);
        m_shapes.clear();
        for (std::size_t i = 0, end = 0; i < all.size(); i = end) {
            check_stop();
            m_feature = all[i].feature;
            while (end < all.size() && all[end].feature == m_feature)
                ++end;
            const std::span<Shape> feature(&all[i], end - i);
            try {
                move(transform, feature);
                m_shapes.insert(m_shapes.end(), feature.begin(), feature.end());
            } catch (const util::Error& e) {
                leave_out(FeatureError(m_attempt + ": feature " + std::to_string(m_feature) + ": " +
                                       e.what()),
                          m_shapes.size());
            }
        }
    }
    template <class Visit>
    static void each(std::span<Shape> shapes, const Visit& visit) {
        for (Shape& shape : shapes)
            for (auto& part : shape.parts)
                for (Shape::Position& position : part)
                    visit(position);
    }

    const std::string m_attempt;
    const std::stop_token& m_stop;
    json m_root;
    std::vector<Shape> m_shapes;
    std::shared_ptr<Lengths> m_lengths;
    std::size_t m_feature = 0;
    std::size_t m_positions = 0;
    std::string m_fault;  ///< of the first feature that is left out
    std::size_t m_faults = 0;
};

}  // namespace

double Shape::metres(const std::string& name) const {
    if (!lengths)
        return kNone;
    if (const auto found = lengths->metres.find(name); found != lengths->metres.end())
        return found->second;
    if (const auto found = lengths->others.find(name); found != lengths->others.end())
        throw util::Error(
            "{} has {} = {}; allowed: a number of metres, or one with its unit: 7 m, 30 ft, 30', "
            "5'6\"",
            lengths->attempt, name, found->second);
    return kNone;
}

std::vector<Shape> read_geojson(const std::filesystem::path& file, const Crs& to,
                                const std::stop_token& stop) {
    return Reader(file, stop).shapes(to);
}

}  // namespace terravox::geo
