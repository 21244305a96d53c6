#pragma once

#include <openssl/err.h>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/x509v3.h>

#include <array>
#include <memory>
#include <string>
#include <vector>

namespace terravox::net {

template <auto kFree>
struct FreeBy {
    template <class T>
    void operator()(T* object) const noexcept {
        kFree(object);
    }
};
using BioPtr = std::unique_ptr<BIO, FreeBy<BIO_free_all>>;
using CertificatePtr = std::unique_ptr<X509, FreeBy<X509_free>>;
using CrlPtr = std::unique_ptr<X509_CRL, FreeBy<X509_CRL_free>>;
using KeyPtr = std::unique_ptr<EVP_PKEY, FreeBy<EVP_PKEY_free>>;

/// OpenSSL's reason for the last failure on this thread; clears it.
inline std::string openssl_reason() {
    const unsigned long code = ERR_get_error();
    ERR_clear_error();
    if (code == 0)
        return "no reason is known";
    const char* reason = ERR_reason_error_string(code);
    if (reason != nullptr)
        return reason;
    std::array<char, 256> text{};
    ERR_error_string_n(code, text.data(), text.size());
    return text.data();
}

/// @return all certificates of a file, in its order
inline std::vector<CertificatePtr> parse_certificates(const std::string& pem) {
    const BioPtr in(BIO_new_mem_buf(pem.data(), static_cast<int>(pem.size())));
    std::vector<CertificatePtr> out;
    while (in) {
        CertificatePtr one(PEM_read_bio_X509(in.get(), nullptr, nullptr, nullptr));
        if (!one)
            break;
        out.push_back(std::move(one));
    }
    ERR_clear_error();  // the end of the file is reported as an error
    return out;
}

/// @return the list of revoked certificates, or null
inline CrlPtr parse_crl(const std::string& pem) {
    const BioPtr in(BIO_new_mem_buf(pem.data(), static_cast<int>(pem.size())));
    CrlPtr out(in ? PEM_read_bio_X509_CRL(in.get(), nullptr, nullptr, nullptr) : nullptr);
    ERR_clear_error();
    return out;
}

/// @return the key, or null; keys with a pass phrase are not supported
inline KeyPtr parse_key(const std::string& pem) {
    const BioPtr in(BIO_new_mem_buf(pem.data(), static_cast<int>(pem.size())));
    const auto no_phrase = [](char*, int, int, void*) { return -1; };
    return KeyPtr(in ? PEM_read_bio_PrivateKey(in.get(), nullptr, no_phrase, nullptr) : nullptr);
}

}  // namespace terravox::net
