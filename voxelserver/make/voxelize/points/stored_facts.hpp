#pragma once

#include <concepts>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <vector>

#include "common/voxel/fingerprint.hpp"

namespace terravox::voxelize {

/// What a function may be given that names the members of a T for both a FactWriter and a
/// FactReader: by each(), maybe() and list(), which are the same there.
template <class Given, class T>
concept MaybeConst = std::same_as<std::remove_const_t<Given>, T>;

/// Writes facts to be stored.
class FactWriter : public voxel::ByteWriter {
public:
    /// Numbers, truth values, texts, paths, and arrays of them.
    template <class... Values>
    void each(const Values&... values) {
        (put(values), ...);
    }
    /// @param members adds those of a value; of one that is missing, those of a new one
    template <class T, class Members>
    void maybe(const std::optional<T>& value, const Members& members) {
        add(value.has_value());
        const T there = value.value_or(T{});
        members(there);
    }
    /// @param min_bytes as FactReader::count()
    template <class T, class Members>
    void list(const std::vector<T>& values, std::size_t /*min_bytes*/, const Members& members) {
        add(static_cast<std::uint64_t>(values.size()));
        for (const T& value : values)
            members(value);
    }

private:
    template <class T>
    void put(const T& value) {
        if constexpr (std::same_as<T, std::filesystem::path>)
            add(value.string());
        else if constexpr (requires { std::tuple_size<T>::value; })
            for (const auto& one : value)
                put(one);
        else
            add(value);
    }
};

/// Reads values written by FactWriter from untrusted bytes: after the first missing value, all
/// further reads return 0 or empty, and ok() returns false.
class FactReader {
public:
    explicit FactReader(std::string_view bytes) : m_left(bytes) {}
    template <class T>
    [[nodiscard]] T get() {
        static_assert(std::is_arithmetic_v<T>);
        T out{};
        if (const auto part = take(sizeof out); !part.empty())
            std::memcpy(&out, part.data(), sizeof out);
        return out;
    }
    [[nodiscard]] std::string text() { return std::string(take(get<std::uint64_t>())); }
    [[nodiscard]] voxel::Fingerprint fingerprint() {
        const auto a = get<std::uint64_t>();
        const auto b = get<std::uint64_t>();
        return {a, b};
    }
    /// Reads the length of a list.
    /// @param min_bytes minimum size of each element in bytes: a list longer than the remaining
    /// bytes allow is invalid
    [[nodiscard]] std::size_t count(std::size_t min_bytes) {
        const auto n = get<std::uint64_t>();
        if (n > m_left.size() / min_bytes)
            m_ok = false;
        return m_ok ? static_cast<std::size_t>(n) : 0;
    }
    // The opposites of those of FactWriter.
    template <class... Values>
    void each(Values&... values) {
        (read(values), ...);
    }
    template <class T, class Members>
    void maybe(std::optional<T>& value, const Members& members) {
        bool is_there = false;
        T there{};
        read(is_there);
        members(there);
        if (is_there)
            value = there;
    }
    template <class T, class Members>
    void list(std::vector<T>& values, std::size_t min_bytes, const Members& members) {
        values.resize(count(min_bytes));
        for (T& value : values)
            members(value);
    }
    /// Whether all reads so far have succeeded.
    [[nodiscard]] bool ok() const noexcept { return m_ok; }
    /// Whether all reads have succeeded and no bytes are left.
    [[nodiscard]] bool finished() const noexcept { return m_ok && m_left.empty(); }

private:
    template <class T>
    void read(T& value) {
        if constexpr (std::same_as<T, std::filesystem::path> || std::same_as<T, std::string>) {
            value = text();
        } else if constexpr (requires { std::tuple_size<T>::value; }) {
            for (auto& one : value)
                read(one);
        } else if constexpr (std::same_as<T, bool>) {
            const auto byte = get<std::uint8_t>();
            m_ok = m_ok && byte <= 1;
            value = byte == 1;
        } else {
            value = get<T>();
        }
    }
    [[nodiscard]] std::string_view take(std::uint64_t size) {
        if (!m_ok || size > m_left.size()) {
            m_ok = false;
            return {};
        }
        const auto out = m_left.substr(0, static_cast<std::size_t>(size));
        m_left.remove_prefix(out.size());
        return out;
    }
    std::string_view m_left;
    bool m_ok = true;
};

}  // namespace terravox::voxelize
