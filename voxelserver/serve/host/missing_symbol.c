/* CivetWeb 1.15 takes its TLS functions from "libssl.so" by name, among them
 * SSL_get_peer_certificate, which OpenSSL 3 has under another name only: it would call a null
 * pointer with the first connection. This library has that name of OpenSSL and the function; all
 * others are found in the real libssl, which it is linked to. host.cpp loads it before
 * CivetWeb asks. */
#include <openssl/ssl.h>

#undef SSL_get_peer_certificate
X509* SSL_get_peer_certificate(const SSL* connection);
X509* SSL_get_peer_certificate(const SSL* connection) {
    return SSL_get1_peer_certificate(connection);
}
